"""Checks of a configuration's faults, against the table of kinds and the bench."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hil.config.catalogue import Catalogue, ProfileInfo
from hil.config.document import Finding
from hil.config.explain import no_such, not_allowed, shown, suggestion
from hil.config.station_names import node_addresses, station_addresses
from hil.config.switch_findings import switch_axes
from hil.sim.given_fault import fault_of
from hil.vocab import faults
from hil.vocab.address import Address, DeviceParts, owner_of

REAL_REMEDY = "leave this key out: a fault of its line is there from the start until it is cleared"


def fault_findings(
    value: Mapping[str, Any],
    devices: Mapping[str, ProfileInfo],
    real: Collection[str],
    full: Collection[str],
    catalogue: Catalogue,
) -> Iterator[Finding]:
    """Findings about the faults of a configuration. ``devices``: those whose profile is known; ``real``: real
    boards; ``full``: addresses of axes with the full plant; ``catalogue``: has the kinds of buses."""
    entries = value.get("faults")
    places = _places(value, devices, real, full, catalogue)
    for kind_of_wire in catalogue.wire_kinds:
        for name, wire in _mappings(value.get(kind_of_wire.key)):
            found = kind_of_wire.fault_places(name, wire, devices)
            places |= {each: set(kinds) for each, kinds in found.items()}
    for name, axis in switch_axes(value, devices).items():
        places.setdefault(str(Address(owner_of(axis), name)), {faults.SWITCH})
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
        elif wanted == faults.OWN_FIELD and isinstance(field := entry.get("field"), str):
            known = devices[owner_of(target)].fields
            if field not in known:
                yield no_such((*path, "field"), f"field of {owner_of(target)}'s own", field, known)
        given = {name: value for name, value in entry.items() if name not in ("fault", "target")}
        _, problems = fault_of(kind, target, given)
        for name, problem in problems.items():
            if name in given:
                yield not_allowed((*path, name), given[name], problem)
            else:
                remedy = problem.removeprefix("this one is missing: ")
                yield Finding((*path, name), "this key is missing", remedy)
        for name in (each.name for each in faults.TIMING if target in real and given.get(each.name)):
            yield Finding((*path, name), f"{target} is a real board", REAL_REMEDY)


def _places(
    value: Mapping[str, Any],
    devices: Mapping[str, ProfileInfo],
    real: Collection[str],
    full: Collection[str],
    catalogue: Catalogue,
) -> dict[str, set[str]]:
    """Targets by name, each with the kinds of target that it is."""
    places: dict[str, set[str]] = {}
    for name, profile in devices.items():
        if name in real:
            places[name] = (
                set() if catalogue.drive_kind(profile) else {faults.PORT}
            )  # a drive has no line of bytes here
        else:
            places |= _of_twin(name, profile, full)
    for name, segment in _mappings(value.get("segments")):
        places[name] = {faults.SEGMENT, faults.LINE}
        for tap in _names(segment.get("taps")):
            places[f"{name}.{tap}"] = {faults.STATION, faults.ON_LINE}
        for node_kind in catalogue.node_kinds:
            kinds = {faults.STATION, faults.ON_LINE, *filter(None, [node_kind.fault_target])}
            places |= dict.fromkeys(node_addresses(node_kind, segment, devices), kinds)
        for station in _names(segment.get("stations")):
            if owner_of(station) not in real:
                for address in station_addresses(station, devices):
                    places.setdefault(address, set()).update((faults.STATION, faults.ON_LINE))
    return places


def _mappings(value: object) -> Iterator[tuple[str, dict[str, Any]]]:
    """Segments or buses by name."""
    for name, each in value.items() if isinstance(value, dict) else ():
        if isinstance(each, dict):
            yield name, each


def _of_twin(name: str, profile: ProfileInfo, full: Collection[str]) -> dict[str, set[str]]:
    """Targets that a twin is: itself, its UARTs and its axes."""
    ports, axes = {faults.PORT, faults.TWIN_PORT}, DeviceParts(profile.axes)
    shafts = {each: _of_axis(axes.label(name, each), profile, each, full) for each in axes}
    places = {f"{name}.{each}": kinds for each, kinds in shafts.items()}
    places |= {f"{name}.{uart}": {faults.DEVICE} | ports for uart in profile.uarts}
    places[name] = {faults.DEVICE} | (ports if profile.uarts else set()) | shafts.get(axes.first, set())
    return {name: places.pop(name)} | places


def _of_axis(address: str, profile: ProfileInfo, axis: str, full: Collection[str]) -> set[str]:
    return {*profile.kind(axis).fault_targets, *([faults.SUPPLIED] if address in full else [])}


def _names(value: Any) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, dict | list) else []
