"""Checks of a configuration's faults, against the table of kinds and the bench."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding
from hil.config.explain import shown, suggestion
from hil.sim.given_fault import fault_of
from hil.vocab import faults
from hil.vocab.axis_plan import AXIS_PINS
from hil.vocab.firmware import MAIN, NETWORK

REAL_REMEDY = "leave this key out: a fault of its line is there from the start until it is cleared"


def fault_findings(
    entries: object,
    segments: object,
    devices: Mapping[str, ProfileInfo],
    real: Collection[str],
    full: Collection[str],
) -> Iterator[Finding]:
    """Findings about the faults of a configuration. ``devices``: those whose profile is known; ``real``: real
    boards; ``full``: those with the full plant."""
    places = _places(segments, devices, real)
    for name in full:
        if name in places:
            places[name].add(faults.SUPPLIED)
    for index, entry in enumerate(entries if isinstance(entries, list) else ()):
        if not isinstance(entry, dict):
            continue
        path = ("faults", index)
        kind, target = entry.get("fault"), entry.get("target")
        if not isinstance(kind, str) or not isinstance(target, str):
            continue
        if kind not in faults.FAULT_KINDS:
            message = f"there is no fault {shown(kind)}"
            yield Finding((*path, "fault"), message, suggestion(kind, faults.FAULT_KINDS))
            continue
        wanted = faults.FAULT_KINDS[kind].target
        if target not in places:
            message = f"there is no {shown(target)} here"
            yield Finding((*path, "target"), message, suggestion(target, places))
        elif wanted not in places[target]:
            fitting = [name for name, kinds in places.items() if wanted in kinds]
            remedy = f"write {faults.TARGETS[wanted]}: {', '.join(fitting) or 'there is none'}"
            yield Finding((*path, "target"), f"{kind} cannot be on {shown(target)}", remedy)
        given = {name: value for name, value in entry.items() if name not in ("fault", "target")}
        _, problems = fault_of(kind, target, given)
        for name, problem in problems.items():
            if name in given:
                yield Finding((*path, name), f"{shown(given[name])} is not allowed here", problem)
            else:
                yield Finding((*path, name), "this key is missing", problem)
        for name in (each.name for each in faults.TIMING if target in real and given.get(each.name)):
            yield Finding((*path, name), f"{target} is a real board", REAL_REMEDY)


def _places(
    segments: object, devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> dict[str, set[str]]:
    """All targets, each with the kinds of target that it is."""
    places: dict[str, set[str]] = {}
    for name, profile in devices.items():
        if name in real:
            places[name] = {faults.PORT}
            continue
        twin = {faults.DEVICE, faults.SHAFT, faults.PORT, faults.TWIN_PORT}
        is_servo = not AXIS_PINS[profile.law].outputs
        places[name] = places[f"{name}.{MAIN}"] = twin | ({faults.SERVO} if is_servo else set())
        if profile.network_baud is not None:
            places[f"{name}.{NETWORK}"] = twin
    for name, segment in segments.items() if isinstance(segments, dict) else ():
        if not isinstance(segment, dict):
            continue
        places[name] = {faults.SEGMENT}
        for tap in _names(segment.get("taps")):
            places[f"{name}.{tap}"] = {faults.STATION}
        for station in _names(segment.get("stations")):
            full = station if "." in station else f"{station}.{NETWORK}"
            places.setdefault(full, set()).add(faults.STATION)
    return places


def _names(value: Any) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, dict | list) else []
