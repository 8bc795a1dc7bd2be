"""The binary layout of a sample, field by field, against the snapshot of the same time."""

import math
from itertools import pairwise

import pytest

from hil.compose import bench_runtime, find_catalogue, start_memories
from hil.compose.replay import MemoryOptions
from hil.config import from_dict
from hil.core.fields import FIELDS, OFFSETS, PACKED_BYTES, reader
from hil.sim.bench import BenchRuntime
from hil.testing.memory_store import MemoryStore
from hil.vocab.packed_fields import STRUCTS
from hil.vocab.time import ms

TABLE = {"flash": {"table": "identity"}}


def runtime(profile: str) -> BenchRuntime:
    device = {"profile": profile, "port": "memory"} | (TABLE if profile == "mechaduino" else {})
    catalogue = find_catalogue({"memory": MemoryOptions})
    config = from_dict({"bench": "t", "devices": {"d": device}}, catalogue)
    memories = start_memories(config, catalogue)
    return bench_runtime(config, catalogue, memories, MemoryStore())


@pytest.mark.parametrize(
    ("profile", "verbs"),
    [
        ("mechaduino", [("enable", {}), ("move_abs", {"position_deg": 90.0})]),
        ("sac", [("velocity", {"velocity_rpm": -60})]),
    ],
)
def test_each_field_is_where_the_table_says(profile: str, verbs: list[tuple[str, dict[str, float]]]) -> None:
    bench = runtime(profile)
    device = bench.devices["d"]
    bench.advance(ms(4500))
    for verb, given in verbs:
        bench.do_verb(device, verb, device.verbs[verb].filled(given))
    bench.watch("d", 0, 1_000_000, 1000)
    seen: dict[str, set[float]] = {name: set() for name in device.axis.kind.fields}
    for _ in range(200):
        bench.advance(ms(bench.now_ns / 1e6 + 1))
        (packed,), lost = bench.take_samples("d", 0)
        now = bench.devices["d"].axis.snapshot().as_dict()
        assert (len(packed), lost) == (PACKED_BYTES, 0)
        assert reader("at_ns")(packed) == bench.now_ns
        for name, values in seen.items():
            value = reader(name)(packed)
            assert value == now[name] or (math.isnan(value) and math.isnan(now[name])), name
            values.add(value)
    moving = ("position_deg", "velocity_rpm", "r" if profile == "mechaduino" else "pulses")
    assert min(len(seen[name]) for name in moving) > 10  # it did move


def test_fields_stand_in_their_order_and_do_not_overlap() -> None:
    assert list(OFFSETS) == list(FIELDS)
    for name, after in pairwise(OFFSETS):
        assert OFFSETS[name] + STRUCTS[FIELDS[name].type].size <= OFFSETS[after]
    assert all(offset % STRUCTS[FIELDS[name].type].size == 0 for name, offset in OFFSETS.items())
    last = next(reversed(OFFSETS))
    assert OFFSETS[last] + STRUCTS[FIELDS[last].type].size <= PACKED_BYTES < OFFSETS[last] + 16
