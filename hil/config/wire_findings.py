"""Wires between the devices' pins, checked against what each kind of board has."""

from collections import Counter
from collections.abc import Collection, Mapping

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown, suggestion
from hil.vocab.axis_plan import AXIS_PINS, CLOCK_IN, CLOCK_OUT, MAX_WIRES


def wire_findings(wires: object, devices: Mapping[str, ProfileInfo], real: Collection[str]) -> list[Finding]:
    """What is wrong with ``wires``; the models tell what has not the form of one. ``devices``: those whose
    profile is known; ``real``: those that are no twins."""
    findings: list[Finding] = []
    driven: dict[tuple[str, object], int] = {}
    begun: Counter[str] = Counter()
    wires = wires if isinstance(wires, list) else []
    for index, wire in enumerate(wires):
        if not isinstance(wire, dict) or not all(isinstance(wire.get(end), str) for end in ("from", "to")):
            continue
        path: KeyPath = ("wires", index)
        ends = {end: _end(wire[end], (*path, end), end, devices, real) for end in ("from", "to")}
        found = [finding for finding in ends.values() if finding]
        findings += found
        if found:
            continue
        (source, output), (device, pin) = (wire[end].split(".", 1) for end in ("from", "to"))
        if (output == CLOCK_OUT) != (pin == CLOCK_IN):
            remedy = f"wire {CLOCK_OUT} to {CLOCK_IN}, and other outputs to other inputs"
            findings.append(Finding(path, f"{shown(output)} and {shown(pin)} do not fit", remedy))
            continue
        begun[source] += output != CLOCK_OUT
        if begun[source] == MAX_WIRES + 1:
            message = f"{source} has {MAX_WIRES} wires already"
            findings.append(Finding((*path, "from"), message, "begin this one at another device"))
        inputs = AXIS_PINS[devices[device].law].inputs
        driver = driven.setdefault((device, inputs.get(pin, pin)), index)
        if driver != index:
            message = f"{wire['to']} is driven by {wires[driver]['from']} already"
            findings.append(Finding((*path, "to"), message, "an input takes one wire: take one of them out"))
    return findings


def _end(
    text: str, path: KeyPath, end: str, devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Finding | None:
    device, dot, pin = text.partition(".")
    if not dot:
        return Finding(path, f"{shown(text)} is no pin", "write the device and its pin, as in s1.clk")
    if device not in devices:
        return Finding(path, f"there is no device {shown(device)}", suggestion(device, devices))
    if device in real:
        return Finding(path, f"{device} is a real board", "wire it by hand; wires here join twins")
    pins = AXIS_PINS[devices[device].law]
    wanted, other = (pins.inputs, pins.outputs) if end == "to" else (pins.outputs, pins.inputs)
    wanted_names = [*wanted, CLOCK_IN if end == "to" else CLOCK_OUT] if pins.outputs else [*wanted]
    if pin in wanted_names:
        return None
    if pin in (*other, CLOCK_OUT if end == "to" else CLOCK_IN):
        kind = "an output" if end == "to" else "an input"
        return Finding(path, f"{pin} of {device} is {kind}", _choice(device, wanted_names))
    remedy = suggestion(pin, wanted_names) if wanted_names else _choice(device, [])
    return Finding(path, f"{device} has no pin {shown(pin)}", remedy)


def _choice(device: str, names: list[str]) -> str:
    return f"write one of {', '.join(names)}" if names else f"{device} has no pin that a wire can begin at"
