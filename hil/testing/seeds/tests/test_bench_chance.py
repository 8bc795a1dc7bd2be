"""Chance of a bench: what a seed changes, and that it is the same everywhere."""

import os
import subprocess
import sys

import pytest

from device_profiles.sac.packet import encode
from hil.compose.replay import replay
from hil.testing import Bench
from hil.testing.seeds.bench_chance import BenchChance, run_seed
from hil.vocab.faults import FaultRefused

LINE = {
    "bench": "line",
    "devices": {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "memory"}}, "baud": 38400}},
    "faults": [{"fault": "wire_noise", "target": "bus0", "rate": 0.01}],
}
NOISY = {"profile": "mechaduino", "plant": "full", "axis": {"encoder_noise_counts": 3}}


def heard(seed: int) -> bytes:
    """Bytes that a tap hears of babble under noise, and that a board sends with bits inverted."""
    with Bench(LINE, seed) as bench:
        bench.fault("byte_flip", "s1", rate=0.02)
        bench.fault("node_babble", "s2.network", every_ms=50)
        for _ in range(20):
            bench.port("s1").write(b"v\r")
            bench.tap("bus0.master").write(encode(4, 1, b"y"))
            bench.run(ms=100)
        return bench.tap("bus0.master").read() + b"|" + bench.port("s1").read()


def test_a_seed_gives_the_same_bytes_and_another_one_others():
    assert heard(17) == heard(17)
    assert len({heard(seed) for seed in range(5)}) == 5


def test_in_another_process_with_another_hash_seed_they_are_the_same():
    code = (
        f"import importlib.util as u; s = u.spec_from_file_location('t', {__file__!r});"
        "t = u.module_from_spec(s); s.loader.exec_module(t); print(repr(t.heard(17)))"
    )
    for hash_seed in ("0", "1"):
        env = os.environ | {
            "PYTHONHASHSEED": hash_seed,
            "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        }
        done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True)
        assert done.stdout.strip() == repr(heard(17)), done.stderr


def test_seeds_are_these_numbers_everywhere():
    chance = BenchChance(17)
    faults = [
        chance.fault("packet_nak", "s4.network", {})[0],
        chance.fault("packet_nak", "s4.network", {})[0],
        chance.fault("packet_nak", "s5.network", {})[0],
        BenchChance(17).fault("packet_nak", "s4.network", {"seed": 3})[0],
    ]
    assert [int(each.number("seed")) for each in faults] == [
        3627343121639846,
        4102430325515458,
        2900864970359841,
        3617524975028171,
    ]
    assert chance.random.random() == 0.5219839097124932


def test_seed_0_leaves_faults_and_axes_their_own():
    with Bench(LINE) as bench:
        bench.fault("packet_nak", "s1.network", seed=5)
        assert [fault.number("seed") for fault in bench.runtime.faults.active.values()] == [0, 5]
        assert bench.config.seed == 0


def test_the_seed_reaches_the_axes():
    def angles(seed: int) -> bytes:
        with Bench({"bench": "full", "devices": {"m1": NOISY}}, seed) as bench:
            bench.start()
            for _ in range(5):
                bench.port("m1").write(b"p")
                bench.run(ms=200)
            return bench.port("m1").read()

    assert angles(1) == angles(1)
    assert len({angles(seed) for seed in range(4)}) == 4


def test_the_seed_of_a_test_and_that_of_a_run_make_one():
    assert [run_seed(0, 0), run_seed(3, 0), run_seed(0, 17)] == [0, 3, 17]
    assert run_seed(3, 17) not in (3, 17, run_seed(17, 3))


def test_a_fault_that_is_left_out_is_not_there_and_changes_no_other():
    def run(leaves_out) -> tuple[list[str], bytes]:
        with Bench(LINE, 17, leaves_out=leaves_out) as bench:
            face = bench.fault("packet_nak", "s1.network", rate=0.5)
            with bench.fault("byte_flip", "s1", rate=0.02):
                bench.run(ms=1200)
                bench.port("s1").read()
                bench.port("s1").write(b"v\r" * 30)
                bench.run(ms=300)
                kinds = [fault.kind for fault in bench.runtime.faults.active.values()]
                assert face.is_active is ("packet_nak" in kinds)
                face.clear()
                return kinds, bench.port("s1").read()

    both, without = run(lambda key: False), run(lambda key: key == ("packet_nak", "s1.network", 1))
    assert both[0] == ["wire_noise", "packet_nak", "byte_flip"]
    assert without[0] == ["wire_noise", "byte_flip"]
    assert both[1] == without[1]
    assert run(lambda key: key[0] == "wire_noise")[0] == ["packet_nak", "byte_flip"]


def test_a_fault_that_is_left_out_is_checked_all_the_same():
    with Bench(LINE, leaves_out=lambda key: True) as bench:
        assert not bench.runtime.faults.active
        with pytest.raises(FaultRefused, match="there is no 's3'"):
            bench.fault("node_reset", "s3")
        with pytest.raises(FaultRefused, match="rate"):
            bench.fault("byte_flip", "s1", rate=2)


def test_a_log_of_a_seed_replays(tmp_path):
    log = tmp_path / "inputs.jsonl"
    with Bench(LINE, 17, arrival_window_ms=20) as bench:
        bench.fault("byte_flip", "s1", rate=0.02)
        for _ in range(30):
            bench.port("s1").write(b"v\r")
            bench.tap("bus0.master").write(encode(4, 1, b"y"))
            bench.run(ms=50)
        with log.open("w") as file:
            bench.inputs.write_to(file)
    assert replay(log).difference() is None
