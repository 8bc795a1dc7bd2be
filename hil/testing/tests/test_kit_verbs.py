"""Verbs stand in the input log: a run with them, refused ones too, is replayed exactly."""

from pathlib import Path
from typing import Any

import pytest

from hil.compose import bench_runtime, find_catalogue, start_memories
from hil.compose.replay import MemoryOptions
from hil.config import from_dict
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.input_reading import decode, read_line
from hil.sim.inputs import Bytes, Do, Logged, Reset, encode_line
from hil.testing import Bench, replay
from hil.testing.memory_store import MemoryStore
from hil.vocab.time import SimTimeNs, ms
from hil.vocab.verbs import VerbRefused

CONFIG: dict[str, Any] = {
    "bench": "t",
    "devices": {
        "m1": {
            "profile": "mechaduino",
            "port": "memory",
            "flash": {"table": "identity"},
            "setpoints": {"timeout_ms": 70, "policy": "decelerate"},
        },
        "s1": {"profile": "sac", "port": "memory", "setpoints": {"timeout_ms": 300, "policy": "hold"}},
    },
    "wires": [{"from": "s1.clk", "to": "m1.step"}],
}
Script = list[tuple[float, str, str, dict[str, float | str]]]
SCRIPT: Script = [
    (3100, "m1", "move_abs", {"position_deg": 5.0}),  # refused: the loop is off
    (4500, "m1", "enable", {}),
    (4700, "m1", "move_abs", {"position_deg": 90.0}),
    (4800.123456, "m1", "move_rel", {"angle_deg": -30.0}),
    (4900, "s1", "move_rel", {"angle_deg": 90.0, "velocity_rpm": 120}),
    (4901, "s1", "move_abs", {"position_deg": 10.0}),  # refused: it moves
    (5500, "m1", "enable", {}),  # p has stopped it
    (5600, "m1", "velocity", {"velocity_rpm": 33.0}),
    (5640, "m1", "velocity", {"velocity_rpm": 66.0}),
    (6000, "s1", "velocity", {"velocity_rpm": 60}),
    (6100, "m1", "stop", {"how": "prejudice"}),
    (6200, "m1", "pulses", {"count": 100, "rate_Hz": 5000.0}),
    (7000, "m1", "calibrate", {}),
]
TEXTS = [(4850, b"p"), (5550, b"xr20\n"), (5650, b"q"), (6500, b"n"), (40_000, b"pq")]
REFUSED = 2


def logged_run(path: Path, chunk_ms: float | None = None) -> tuple[Any, int]:
    """Run a bench with a log, and return its devices and how many verbs were refused."""
    catalogue = find_catalogue({"memory": MemoryOptions})
    config = from_dict(CONFIG, catalogue)
    memories = start_memories(config, catalogue)
    refused = 0

    def until(at_ms: float) -> None:
        while chunk_ms and runtime.now_ns + ms(chunk_ms) < ms(at_ms):
            runtime.advance(SimTimeNs(runtime.now_ns + ms(chunk_ms)))
        runtime.advance(ms(at_ms))

    events: list[tuple[float, Any]] = [(row[0], row) for row in SCRIPT] + list(TEXTS)
    with path.open("w") as file:
        around = BenchHooks(log=InputLogWriter(file, "test", CONFIG, memories))
        runtime = bench_runtime(config, catalogue, memories, MemoryStore(), around)
        for at_ms, what in sorted(events, key=lambda event: event[0]):
            until(at_ms)
            if isinstance(what, bytes):
                runtime.apply_to(runtime.devices["m1"], Bytes(what))
                continue
            _, name, verb, parameters = what
            device = runtime.devices[name]
            try:
                at_ns, _ = runtime.do_verb(device, verb, device.verbs[verb].filled(parameters))
                assert at_ns == ms(at_ms)
            except VerbRefused:
                refused += 1
        until(41_000)
        runtime.apply_to(runtime.devices["m1"], Reset())
        until(44_500)
        runtime.apply_to(runtime.devices["m1"], Bytes(b"p"))
        until(45_000)
    return runtime.devices, refused


def test_a_run_with_verbs_is_replayed_from_its_log(tmp_path: Path) -> None:
    devices, refused = logged_run(tmp_path / "log")
    assert refused == REFUSED
    assert [device.setpoints.starved for device in devices.values()] == [1, 1]
    again = replay(tmp_path / "log")
    assert again.difference() is None
    assert sum(isinstance(logged.input, Do) for logged in again.logged.inputs) == len(SCRIPT)
    again.runtime.advance(ms(45_000))
    for name, device in devices.items():
        twin = again.runtime.devices[name]
        assert twin.axis.snapshot() == device.axis.snapshot()
        assert (twin.nvm, twin.notes) == (device.nvm, device.notes)
        assert twin.setpoints.starved == device.setpoints.starved
    sent = b"".join(each.data for each in again.sent["m1"])
    assert sent.count(b"Beginning calibration") == 1


def test_a_log_with_verbs_does_not_tell_how_the_run_was_cut(tmp_path: Path) -> None:
    logged_run(tmp_path / "one")
    logged_run(tmp_path / "many", chunk_ms=0.9)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "many").read_bytes()


@pytest.mark.parametrize(
    "given", [Do("stop"), Do("gains", (("pKp", 1.5), ("vKi", 2))), Do("stop", (("how", "grace"),))]
)
def test_a_verb_as_a_line_of_the_log(given: Do) -> None:
    logged = Logged(SimTimeNs(12), "m1", given)
    assert decode(read_line(encode_line(logged))) == logged


def test_refusals_name_what_there_is() -> None:
    with Bench(CONFIG) as bench:
        bench.run(1500)
        with pytest.raises(VerbRefused, match="there are velocity, move_rel, move_abs, queue, run, loop"):
            bench.axis("s1").do("enable")
        with pytest.raises(VerbRefused, match="position_deg: this one is missing: where to"):
            bench.axis("s1").do("move_abs")
