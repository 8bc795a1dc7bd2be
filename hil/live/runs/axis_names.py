"""Names of axes in a run over benches: ``m1`` is of the bench it is submitted to, ``lathe/m1`` of another."""

from hil.config.document import Finding
from hil.runs import RunDocument


def split(axis: str, here: str) -> tuple[str, str]:
    """Split a name into bench and device."""
    bench, slash, device = axis.partition("/")
    return (bench, device) if slash else (here, axis)


def device_names(run: RunDocument, here: str, of: str | None = None) -> dict[str, str]:
    """Devices of a bench (``of``, else this one) that take part, by their names in the run."""
    wanted = here if of is None else of
    return {axis: split(axis, here)[1] for axis in run.axes if split(axis, here)[0] == wanted}


def other_benches(run: RunDocument, here: str) -> list[str]:
    """Names of the other benches, in the order in which the run names them."""
    return list(dict.fromkeys(bench for axis in run.axes if (bench := split(axis, here)[0]) != here))


def taken_twice(run: RunDocument, here: str) -> list[Finding]:
    """Find axes that have two names in the run."""
    seen: dict[tuple[str, str], str] = {}
    findings = []
    for axis in run.axes:
        if (which := split(axis, here)) in seen:
            why = f"it is {seen[which]} once more"
            findings.append(Finding(("axes", axis), why, "leave it out", at_key=True))
        seen[which] = axis
    return findings
