"""The inputs that a bench keeps: their log is the one that a writer makes, and replays."""

import io
import json
from pathlib import Path

import pytest

from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Bytes, Inject
from hil.sim.log_checks import without_checks
from hil.testing import Bench, replay

CONFIG = {
    "bench": "b",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {}}}},
    "faults": [{"fault": "byte_flip", "target": "s1", "rate": 0.001}],
}


def used(bench: Bench) -> None:
    """Type, commit flash, play on the wire, disturb it and switch the power."""
    bench.start()
    m1 = bench.port("m1")
    for line in (b"y", b"r90\n", b"e1\n", b"z"):
        m1.write(line)
        bench.run(300)
    bench.port("s1").write(b"$CM7\r")
    bench.run(20)
    bench.port("s2").write(b"$CM8\r")
    bench.run(400)
    with bench.fault("packet_nak", "s2.network", rate=0.5):
        for _ in range(3):
            bench.tap("bus0.master").write(bytes.fromhex("0208000179007e03"))
            bench.run(5)
    bench.axis("m1").load_torque_Nm = 0.01
    bench.device("m1").reset()
    bench.run(2000)


def lines_of(text: str) -> list[dict[str, object]]:
    """Lines without checks, which are of other states."""
    return [json.loads(line) for line in text.splitlines() if '"check":' not in line]


def test_the_log_is_that_of_a_writer_without_states() -> None:
    written, kept = io.StringIO(), io.StringIO()
    log = InputLogWriter(written, "test", CONFIG, {})
    with Bench(CONFIG, around=BenchHooks(log=log)) as bench:
        used(bench)
        log.end()
        bench.inputs.write_to(kept)
        assert [each.input for each in bench.inputs.inputs if isinstance(each.input, Inject)]
        assert Bytes(b"y") in [each.input for each in bench.inputs.inputs]
    theirs, ours = lines_of(written.getvalue())[1:], lines_of(kept.getvalue())[1:]
    assert len(ours) > 30
    assert ours == [each | ({"state": None} if "sent" in each else {}) for each in theirs]
    assert any(each.get("input") == "commit_done" for each in ours)


def test_the_log_replays_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "kept.jsonl"
    with Bench(CONFIG) as bench:
        used(bench)
        with path.open("w") as file:
            bench.inputs.write_to(file)
    replayed = replay(path)
    assert replayed.difference() is None
    assert replayed.logged.cut == ""
    assert "0 states of axes" in replayed.summary()


@pytest.mark.parametrize("change", [("2d2d", "2d2e"), ('"sent":"', '"sent":"00')])
def test_another_byte_is_a_difference_without_states(change: tuple[str, str]) -> None:
    text = io.StringIO()
    with Bench(CONFIG) as bench:
        bench.start()
        bench.inputs.write_to(text)
    assert change[0] in text.getvalue()
    difference = replay(without_checks(text.getvalue().replace(*change, 1))).difference()
    assert difference
    assert "piece" in difference
