"""Twins as doors and registers see them: verbs, fields and pins; an axis at one simulated time."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from hil.core import AxisKind, Snapshot
from hil.core.fields import OFFSETS, TABLE, packed
from hil.sim.twin import Twin
from hil.vocab.address import address_of
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisField, AxisLook, DeviceInfo
from hil.vocab.profile import Profile
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Verb


def info_of(device: Twin, part: str, board: Profile) -> DeviceInfo:
    """Describe a device with its first axis, or another of its axes. ``part``: the axis's name."""
    kind = device.axes[part].kind if device.axes else None
    info = twin_info(device.axes.label(device.name, part), device.profile, board, kind)
    return replace(info, own_map=device.own_map) if device.own_map and not part else info


@lru_cache(2048)
def twin_info(address: str, profile: str, board: Profile, kind: AxisKind | None) -> DeviceInfo:
    """Describe a device with its first axis, or another of its axes."""
    is_other, has_axis = bool(address_of(address).part), kind is not None
    table = {name: verb for name, verb in board.table.items() if board.uarts or name != "type"}
    verbs = {name: verb for name, verb in table.items() if _can(verb, is_other, has_axis)}
    if kind is None:
        return DeviceInfo(address, profile, False, verbs, {}, readers=board.readers)
    fields = _fields(kind, board.shown_first)
    return DeviceInfo(address, profile, False, verbs, fields, _inputs(kind), readers=board.readers)


def _can(verb: Verb, is_other: bool, has_axis: bool) -> bool:
    """True if a verb can be asked at an address: of a device, or of another axis than its first
    (``is_other``), which takes only verbs of axes."""
    is_of_axis = verb.is_of_axis or verb.name == "pin"
    return is_of_axis if is_other else has_axis or not is_of_axis


@lru_cache
def _fields(kind: AxisKind, shown_first: tuple[str, ...]) -> Mapping[str, AxisField]:
    settable = kind.settable
    return {
        name: AxisField(
            name,
            f.type,
            f.unit,
            f.meaning,
            OFFSETS[TABLE[index].name],
            name in settable,
            name in shown_first or name in kind.board_fields,
        )
        for name, index in kind.fields.items()
        for f in (kind.described(name),)
    }


@lru_cache
def _inputs(kind: AxisKind) -> Mapping[str, str]:
    names: dict[int, list[str]] = {}
    for name, number in kind.inputs.items():
        names.setdefault(number, []).append(name)
    inputs = {}
    for number, pin in sorted(names.items()):
        told = {name: field for name in pin if (field := f"pin_{name.lower()}") in kind.fields}
        name = next(iter(told), pin[0])
        inputs[name] = told.get(name, f"{kind.levels}.{number}" if kind.levels else "")
    return inputs


def board_look(device: Twin, now_ns: int) -> AxisLook:
    """Look at a board without an axis: what its firmware tells."""
    nowhere = AxisState(SimTimeNs(now_ns), None, None, is_moving=False, is_under_way=False)
    return AxisLook(b"", nowhere, device.failed, dict(device.told))


def axis_look(device: Twin, kind: AxisKind, shot: Snapshot) -> AxisLook:
    """Look at an axis of a kind in a snapshot of now; ``device``: whose it is."""
    return AxisLook(packed(shot.values), kind.motion(shot), device.failed, dict(device.told))
