"""Fields of a real drive as doors see them: the binary layout that twins have where they have the same field,
and a part of its own behind it."""

from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from math import nan
from struct import Struct

from hil.core.fields import FIELDS, OFFSETS
from hil.vocab.desk_protocol import AxisField
from hil.vocab.drive_words import TAKEN, TOLD
from hil.vocab.packed_fields import struct_of
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Effect, Verb

ANGLE_DEG, MOST_RPM, MOST_RPM_PER_S = 1e9, 1e5, 1e7
FOLLOW_RPM, FOLLOW_RPM_PER_S = 60.0, 600.0
"""Ramps of a move that the daemon makes for a drive that only follows set-points."""


def common_verbs(ramps: Sequence[Parameter], stops: str) -> list[Verb]:
    """Verbs that all drives have. ``ramps``: parameters of a move beside its target; ``stops``: the end of a
    motion by this kind of drive, in words."""
    return [
        drive_verb("enable", "switch the loop on, which holds the shaft where it is"),
        drive_verb("disable", "switch the loop off"),
        drive_verb(
            "move_abs",
            "go to an angle with ramps",
            Parameter("position_deg", "where to", "deg", -ANGLE_DEG, ANGLE_DEG),
            *ramps,
        ),
        drive_verb(
            "move_rel",
            "go by an angle with ramps, from where the last motion leads",
            Parameter("angle_deg", "how far", "deg", -ANGLE_DEG, ANGLE_DEG),
            *ramps,
        ),
        drive_verb("stop", stops),
    ]


def drive_verb(name: str, about: str, *parameters: Parameter) -> Verb:
    """Verb of a drive. All of them end a run that has it."""
    return Verb(name, about, parameters, effect=Effect.ENDS)


OWN_AT, PARAMETERS_AT, MORE_PARAMETERS_AT = 1024, 1536, 8192
"""Offsets of the fields that no twin has, and of parameters that no twin has: bytes. Doors of Modbus have a
register of half the number; parameters of verbs are between the last two."""
NEAR_PARAMETERS = 57
FieldRow = tuple[str, str, str, str]
"""Field of a drive: name, type, unit, meaning."""
_UNITS = {"position_deg": "deg", "velocity_rpm": "rpm", "current_A": "A", "set_point_deg": "deg"}
_LINK = (
    ("connected", "i32", "", "1 while the drive answers"),
    ("age_ms", "f64", "ms", "time since the request whose answer the rest of this state is from"),
    ("polls", "i64", "", "complete readings of the drive's state"),
    ("writes", "i64", "", "writes that the drive confirmed"),
    ("time_outs", "i64", "", "requests that were not answered in time"),
    ("garbled", "i64", "", "answers that did not fit their request"),
    ("exceptions", "i64", "", "answers that were exceptions"),
    ("reconnects", "i64", "", "times that it was there again"),
    ("round_trip_p50_ms", "f64", "ms", "median of the last round trips"),
    ("round_trip_p99_ms", "f64", "ms", "99th percentile of the last round trips"),
)
_SHORT = ("at_ns", "position_deg", "velocity_rpm", "commanded_deg", "enabled", "moving", "fault", "connected")
_OWN_NAMES = ("current_A", "fault_code", "enabled", "moving", "fault", *(row[0] for row in _LINK))
"""Fields that no twin has, before those of a bus. The order is a promise."""


def drive_fields(
    told: Collection[str],
    parameters: Collection[str] = (),
    own: Sequence[FieldRow] = (),
    *,
    has_position: bool = True,
) -> dict[str, AxisField]:
    """Fields of a drive, by name, in the order of their offsets. ``told``: names of what it tells beside its
    position; ``parameters``: of what can be set; ``own``: fields of its bus alone, whose order is a promise:
    new ones go to the end; ``has_position``: it tells one at all."""
    rows = [("at_ns", "i64", "ns", "simulated time of the request that this state is from", False)]
    if has_position:
        rows.append(("position_deg", "f64", "deg", TOLD["position_deg"], False))
        rows.append(("commanded_deg", "f64", "deg", TAKEN["set_point_deg"], False))
    for name in ("velocity_rpm", "current_A", "fault_code"):
        if name in told:
            rows.append((name, "f64", _UNITS.get(name, ""), TOLD[name], False))
    meanings = {
        "enabled": "1 while the loop is on",
        "moving": "1 while it moves",
        "fault": "1: it has a fault",
    }
    rows += [(name, "i32", "", about, False) for name, about in meanings.items()]
    rows += [(*row, False) for row in _LINK]
    rows += [(*row, False) for row in own]
    own_names = (*_OWN_NAMES, *(row[0] for row in own))
    own_offsets = {name: OWN_AT + 8 * index for index, name in enumerate(own_names)}
    offsets = {row[0]: OFFSETS.get(row[0], own_offsets.get(row[0], 0)) for row in rows}
    for index, name in enumerate(sorted(parameters)):
        known = FIELDS.get(name)
        offsets[name] = OFFSETS[name] if known else _parameter_offset(index)
        unit, about = (known.unit, known.meaning) if known else ("", "register of the drive")
        rows.append((name, known.type if known else "f64", unit, about, True))
    fields = [
        AxisField(name, kind, unit, about, offsets[name], settable, name in (*_SHORT, "age_ms"))
        for name, kind, unit, about, settable in rows
    ]
    return {each.name: each for each in sorted(fields, key=lambda each: each.offset)}


def _parameter_offset(index: int) -> int:
    far = index - NEAR_PARAMETERS
    return PARAMETERS_AT + 8 * index if far < 0 else MORE_PARAMETERS_AT + 8 * far


@lru_cache(64)
def _struct(layout: tuple[tuple[str, int], ...]) -> Struct:
    return struct_of(layout)


def packed(fields: Mapping[str, AxisField], values: Mapping[str, float]) -> bytes:
    """Pack values in the binary layout of these fields; what is not told is NaN, or 0 of a whole number."""
    layout = tuple((each.type, each.offset) for each in fields.values())
    row = []
    for name, each in fields.items():
        value = values.get(name, nan)
        is_whole = each.type.startswith("i")
        row.append((0 if value != value else round(value)) if is_whole else value)
    return _struct(layout).pack(*row)
