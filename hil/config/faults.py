"""Faults of the configuration, checked against the table of kinds."""

from collections.abc import Collection

from hil.config.document import Finding
from hil.config.explain import shown, suggestion
from hil.vocab.faults import FAULT_KINDS, fault_of


def fault_findings(faults: object, real: Collection[str]) -> list[Finding]:
    """What is wrong with ``faults``. ``real``: devices that are real boards, which byte faults can be on."""
    findings: list[Finding] = []
    for index, entry in enumerate(faults if isinstance(faults, list) else ()):
        if not isinstance(entry, dict):
            continue
        path = ("faults", index)
        kind, target = entry.get("fault"), entry.get("target")
        if not isinstance(kind, str) or not isinstance(target, str):
            continue
        if kind not in FAULT_KINDS:
            message = f"there is no fault {shown(kind)}"
            findings.append(Finding((*path, "fault"), message, suggestion(kind, FAULT_KINDS)))
            continue
        if target not in real:
            remedy = suggestion(target, real) if real else "there is none: a device with at: is one"
            findings.append(Finding((*path, "target"), f"{shown(target)} is no real board", remedy))
        given = {name: value for name, value in entry.items() if name not in ("fault", "target")}
        _, problems = fault_of(kind, target, given)
        for name, problem in problems.items():
            if name in given:
                findings.append(Finding((*path, name), f"{shown(given[name])} does not do here", problem))
            else:
                findings.append(Finding((*path, name), "this key is missing", problem))
    return findings
