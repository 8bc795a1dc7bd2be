"""The same configuration and inputs give the same bytes, times and states: again, in another process,
in other pieces, beside other benches, and from the log."""

import hashlib
import os
import random
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.compose import bench_runtime, find_catalogue
from hil.compose.replay import MemoryOptions
from hil.config import from_dict
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter, Sent, sent_now
from hil.sim.inputs import Bytes, Pin, Reset, ScriptEncoder, SetField
from hil.sim.log_checks import without_checks
from hil.sim.twin import Twin
from hil.testing import Bench, replay
from hil.vocab.firmware import MAIN
from hil.vocab.time import SimTimeNs, ms

DEVICE = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
CONFIG = {"bench": "same", "devices": {"m1": DEVICE}}
SCRIPT: list[tuple[float, bytes]] = [
    (3500, b"sp"),
    (4400, b"xy"),
    (4600, b"r-90.25\n"),
    (4700, b"kpp12\ni0.15\nq"),
    (4800, b"e"),
    (4850, b"vr120\n"),
    (5100, b"tr-20\nbogus\xff\x00"),
    (5200, b"xr12"),
    (5300, b".5"),
    (6400, b"m\n"),
    (6450, b"p"),
    (6600, b"y"),
]
END_MS = 6900.0


def drive(bench: Bench, script: Sequence[tuple[float, bytes]] = SCRIPT, end_ms: float = END_MS) -> None:
    for at_ms, data in script:
        bench.run_until(at_ms)
        bench.port("m1").write(data)
    bench.run_until(end_ms)


def outcome(bench: Bench) -> str:
    """Hash of everything that can be seen of a run."""
    port, axis = bench.port("m1"), bench.axis("m1")
    seen = f"{port.read_timed()}{axis.snapshot().values}{bench.device('m1').failed}"
    return hashlib.sha256(seen.encode()).hexdigest()


def run_once() -> str:
    bench = Bench(CONFIG)
    drive(bench)
    return outcome(bench)


@pytest.mark.long
def test_a_hundred_runs_are_one() -> None:
    assert len({run_once() for _ in range(100)}) == 1


@pytest.mark.thorough
@pytest.mark.long
def test_another_process_with_another_hash_seed_does_the_same() -> None:
    program = (
        "import importlib.util, sys\n"
        f"spec = importlib.util.spec_from_file_location('same', {__file__!r})\n"
        "module = importlib.util.module_from_spec(spec); spec.loader.exec_module(module)\n"
        "print(module.run_once())\n"
    )
    found = set()
    for seed in ("0", "1", "4294967295"):
        env = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        done = subprocess.run(
            [sys.executable, "-c", program], env=env, capture_output=True, text=True, check=True
        )
        found.add(done.stdout.strip())
    assert found == {run_once()}


def cut(data: bytes, sizes: Sequence[int]) -> list[bytes]:
    pieces = []
    for size in sizes:
        pieces.append(data[:size])
        data = data[size:]
    return [*pieces, data]


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_pieces_of_running_and_writing_do_not_matter(data: st.DataObject) -> None:
    bench = Bench(CONFIG)
    stops = data.draw(st.lists(st.floats(0, END_MS), max_size=25))
    sizes = data.draw(st.lists(st.integers(0, 3), max_size=5))
    events: list[tuple[float, bytes | None]] = [(at_ms, None) for at_ms in stops]
    events += [(at_ms, text) for at_ms, text in SCRIPT]
    for at_ms, text in sorted(events, key=lambda event: event[0]):
        bench.run_until(at_ms)
        bench.axis("m1").snapshot()  # looking changes nothing
        for piece in cut(text, sizes) if text is not None else []:
            bench.port("m1").write(piece)
    bench.run_until(END_MS)
    assert outcome(bench) == ALONE


ALONE = run_once()


def test_a_hundred_benches_in_turns_are_each_as_if_alone() -> None:
    benches = [Bench(CONFIG) for _ in range(100)]
    order = random.Random(7)
    for at_ms, text in [*SCRIPT, (END_MS, b"")]:
        order.shuffle(benches)
        for bench in benches:
            bench.run_until(at_ms - order.uniform(0, 50))
        for bench in benches:
            bench.run_until(at_ms)
            bench.port("m1").write(text)
    assert {outcome(bench) for bench in benches} == {ALONE}


def test_devices_of_one_bench_are_each_as_if_alone() -> None:
    bench = Bench({"bench": "same", "devices": {"m1": DEVICE, "m2": DEVICE, "m3": DEVICE}})
    bench.run(4100)
    bench.port("m3").write(b"xyr77\n")
    bench.port("m2").write(b"c")
    alone = Bench(CONFIG)
    alone.run(4100)
    for each in (bench, alone):
        each.port("m1").write(b"vyr50\n")
        each.run(2000)
    assert outcome(bench) == outcome(alone)


# ---- speed ----


def test_a_calibration_takes_less_than_a_second() -> None:
    bench = Bench(CONFIG)
    bench.run(5000)
    start_s = process_time()
    bench.port("m1").write(b"c")
    bench.run(27000)
    assert process_time() - start_s < 1.0
    assert bench.port("m1").read().endswith(b"non-volatile Flash memory!\r\n \r\n \r\n")


def test_a_bench_is_made_in_a_moment() -> None:
    # The bound is far above what is usual, for slow machines; benchmarks watch the figure itself.
    def make_s() -> float:
        start_s = process_time()
        Bench(CONFIG)
        return process_time() - start_s

    assert median(make_s() for _ in range(15)) < 0.25


# ---- the input log ----


class LateStore:
    """Memory whose answers are inputs of their own, as a daemon's are."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[bool], bool]] = []

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        self.waiting.append(answered)
        return None


def logged_run(path: Path, chunks: int = 1) -> tuple[Twin, list[Sent]]:
    """Run a bench with every kind of input and its log in ``path``, and return the device and what it
    sent."""
    store = LateStore()
    with Bench(CONFIG) as bench:
        memories = {"m1": dict(bench.device("m1").nvm)}
    config = from_dict(CONFIG, find_catalogue({"memory": MemoryOptions}))
    heard: list[Sent] = []

    def until(at_ms: float) -> None:
        step_ns = (ms(at_ms) - runtime.now_ns) // chunks
        for _ in range(chunks - 1):
            runtime.advance(SimTimeNs(runtime.now_ns + step_ns))
        runtime.advance(ms(at_ms))

    with path.open("w") as file:
        around = BenchHooks(log=InputLogWriter(file, "test", CONFIG, memories))
        catalogue = find_catalogue({"memory": MemoryOptions})
        runtime = bench_runtime(config, catalogue, memories, store, around)
        device = runtime.devices["m1"]
        device.uarts[MAIN].listeners.append(
            lambda at_ns, data: heard.append(sent_now(device, MAIN, at_ns, data))
        )
        for at_ms, text in SCRIPT:
            until(at_ms)
            runtime.apply_to(device, Bytes(text))
        until(6990)
        runtime.apply_to(device, ScriptEncoder(((7_000_000_000, 100), (7_100_000_000, -3000)), True))
        runtime.apply_to(device, SetField("load_torque_Nm", 0.02))
        runtime.apply_to(device, SetField("errfl", 3))
        runtime.apply_to(device, Pin("D1", 1))
        until(7050)
        runtime.apply_to(device, Bytes(b"ep"))
        until(7200)
        runtime.apply_to(device, Reset())
        runtime.apply_to(device, ScriptEncoder((), False))
        until(11500)
        runtime.apply_to(device, Bytes(b"c"))
        until(38500)
        assert len(store.waiting) == 1
        assert store.waiting[0](True)
        runtime.apply_to(device, Bytes(b"p"))
        until(39000)
    return device, heard


def test_a_run_is_replayed_from_its_log(tmp_path: Path) -> None:
    device, heard = logged_run(tmp_path / "log")
    again = replay(tmp_path / "log")
    assert again.sent["m1"] == heard == again.logged.sent
    assert again.difference() is None
    assert b"".join(sent.data for sent in heard).count(b"Calibration complete!") == 1
    again.runtime.advance(ms(39000))
    assert again.runtime.devices["m1"].axis.snapshot() == device.axis.snapshot()
    assert again.runtime.devices["m1"].nvm == device.nvm
    assert f"{len(again.logged.inputs)} inputs, " in again.summary()


@pytest.mark.parametrize("stop_ms", [4600, 5500, 20_000])
def test_a_run_that_was_ended_in_a_long_answer_replays_identically(tmp_path: Path, stop_ms: int) -> None:
    """``q`` takes 22 s on the line at 57600 baud, and the board then does what was typed behind it."""
    config: dict[str, Any] = {
        "bench": "t",
        "devices": {
            "m1": {"profile": "mechaduino", "baud": 57600, "flash": {"table": "identity"}},
            "s1": {"profile": "sac"},
        },
        "wires": [{"from": "s1.clk", "to": "m1.step"}],
    }
    with Bench(config) as bench:
        memories = {name: dict(bench.device(name).nvm) for name in config["devices"]}
    catalogue = find_catalogue({"memory": MemoryOptions})
    with (tmp_path / "log").open("w") as file:
        around = BenchHooks(log=InputLogWriter(file, "test", config, memories))
        runtime = bench_runtime(from_dict(config, catalogue), catalogue, memories, LateStore(), around)
        runtime.advance(ms(4500))
        runtime.apply_to(runtime.devices["m1"], Bytes(b"qm"))
        runtime.apply_to(runtime.devices["s1"], Bytes(b"m100v1\r"))
        runtime.advance(ms(stop_ms))
    again = replay(tmp_path / "log")
    assert again.difference() is None


def test_a_log_does_not_tell_how_the_run_was_cut(tmp_path: Path) -> None:
    logged_run(tmp_path / "one")
    logged_run(tmp_path / "many", chunks=17)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "many").read_bytes()


def test_a_replay_that_differs_says_where(tmp_path: Path) -> None:
    logged_run(tmp_path / "log")
    lines = without_checks((tmp_path / "log").read_text())
    changed = [line.replace(b"xy".hex(), b"vy".hex()) for line in lines]
    assert changed != lines
    difference = replay(changed).difference()
    assert difference is not None
    assert difference.startswith("m1, piece ")
