"""States as the bridge publishes them: from the binary layout, byte for byte what JSON makes of it."""

import json
import math
import random
from struct import Struct

import pytest

from bridges.zenoh.publications import StateText
from hil.vocab.desk_protocol import AxisField
from hil.vocab.packed_fields import struct_of

FIELDS = [
    AxisField(name, type_, "", "", offset, False, True)
    for name, type_, offset in (
        ("at_ns", "i64", 0),
        ("mode", "i32", 8),
        ("r", "f32", 12),
        ("position_deg", "f64", 16),
        ("torque_Nm", "f64", 32),
    )
]
WALL_NS = 1795254243120000000


def packed(*values: float) -> bytes:
    return struct_of((field.type, field.offset) for field in FIELDS).pack(*values)


def compact(data: bytes) -> bytes:
    """The same values as JSON without spaces: numbers as Python writes them."""
    read = struct_of((field.type, field.offset) for field in FIELDS).unpack(data)
    values = dict(zip((field.name for field in FIELDS), read, strict=True))
    return json.dumps({"v": 1, "wall_ns": WALL_NS} | values, separators=(",", ":")).encode()


def test_numbers_are_those_of_json() -> None:
    text, chance = StateText(FIELDS), random.Random(7)
    for _ in range(500):
        f32 = Struct("<f").unpack(Struct("<f").pack(chance.uniform(-1e3, 1e3)))[0]
        data = packed(
            *(chance.randrange(1 << 62), chance.randrange(-9, 9), f32),
            *(chance.uniform(-360, 360), chance.uniform(-1, 1) * 10 ** chance.randrange(-30, 300)),
        )
        assert text.of(data, WALL_NS) == compact(data)


def test_a_sum_that_no_float_holds_is_no_value() -> None:
    data = packed(1, 0, 0.0, 1.7e308, 1.7e308)
    assert StateText(FIELDS).of(data, WALL_NS) == compact(data)


@pytest.mark.parametrize("strange", [math.nan, math.inf, -math.inf])
def test_what_json_has_not_is_null(strange: float) -> None:
    for values in ((strange, 1.5), (1.5, strange), (strange, -strange)):
        told = json.loads(StateText(FIELDS).of(packed(1, 0, 0.25, *values), WALL_NS))
        assert told == {
            **{"v": 1, "wall_ns": WALL_NS, "at_ns": 1, "mode": 0, "r": 0.25},
            "position_deg": values[0] if math.isfinite(values[0]) else None,
            "torque_Nm": values[1] if math.isfinite(values[1]) else None,
        }
