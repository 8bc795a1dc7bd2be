"""Records of the input log that wait: the log has the same bytes as one whose records do not."""

import io
import random

import pytest

from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Bytes, Reset
from hil.sim.log_reading import read_input_log
from hil.testing import Bench

CONFIG = {
    "bench": "b",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac", "flash": {}},
        "s2": {"profile": "sac", "flash": {}},
    },
    "segments": {"bus0": {"stations": ["s2"], "taps": {"master": {}}}},
}


def logged(batch: int) -> str:
    """Log of a run; half a batch is written when so many records wait, at 0 each at once."""
    file, waited = io.StringIO(), [0]

    def later(waiting: int) -> None:
        waited[0] = max(waited[0], waiting)
        if waiting >= batch:
            log.write_waiting(batch // 2)

    log = InputLogWriter(file, "test", CONFIG, {}, later if batch else None)
    chance = random.Random(7)
    with Bench(CONFIG, around=BenchHooks(log=log)) as bench:
        devices = bench._runtime.devices
        for _ in range(80):
            bench.run(chance.choice([0.5, 20.0, 200.0]))
            given = chance.choice([Bytes(b"y"), Bytes(b"r"), Bytes(b"1.5\n"), Bytes(b"p", 9600), Reset()])
            bench._runtime.apply_to(devices[chance.choice(["m1", "s1", "s2"])], given)
    log.end()
    assert waited[0] == batch
    return file.getvalue()


@pytest.mark.parametrize("batch", [8, 64])
def test_records_that_wait_are_written_as_if_they_had_not(batch: int) -> None:
    at_once = logged(0)
    assert logged(batch) == at_once
    log = read_input_log(io.StringIO(at_once))
    assert len(log.inputs) >= 80
    assert len({sent.state for sent in log.sent}) > 20
