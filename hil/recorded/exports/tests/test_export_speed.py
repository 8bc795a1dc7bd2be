"""An hour of two boards in closed loop, at 100 Hz, is exported in at most 10 s of a processor."""

from io import BytesIO
from time import process_time

import pytest

from hil.recorded.exports.csv_table import write_csv
from hil.recorded.exports.export_names import wanted_fields
from hil.recorded.recorded_run import RecordedRun
from hil.sim.input_log import InputLog
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

pytestmark = pytest.mark.thorough
M1 = {"profile": "mechaduino", "flash": {"table": "identity"}}
HOUR_NS = SimTimeNs(3600 * NS_PER_S)
MOST_S = 10.0


@pytest.fixture(scope="module")
def log() -> InputLog:
    with Bench({"bench": "two", "devices": {"m1": M1, "m2": M1}}) as bench:
        bench.start()
        for name in ("m1", "m2"):
            for text in (b"y", b"x"):
                bench.port(name).write(text)
                bench.run(50)
        for move in range(180):  # one each 20 s
            for name in ("m1", "m2"):
                bench.port(name).write(b"r%d\n" % (move * 37 % 360))
            bench.run(20_000)
        return bench.inputs.log()


def test_a_table(log: InputLog) -> None:
    run, file, begun_s = RecordedRun(log), BytesIO(), process_time()
    fields = wanted_fields(run, [])
    rows = write_csv(file, run, fields, SimTimeNs(0), HOUR_NS, 10 * NS_PER_MS)
    assert rows == 360_001
    assert process_time() - begun_s < MOST_S
    assert file.getvalue().count(b"\n") == rows + 1


def test_mcap(log: InputLog) -> None:
    pytest.importorskip("mcap", reason="the extra mcap is not installed: make .venv/.dev")
    from hil.recorded.exports.export_names import wanted_of_all
    from hil.recorded.exports.mcap_export import McapContent, write_mcap

    run, file, begun_s = RecordedRun(log), BytesIO(), process_time()
    content = McapContent(*wanted_of_all(run, []))
    messages = write_mcap(file, run, content, SimTimeNs(0), HOUR_NS, 10 * NS_PER_MS)
    assert messages > 720_000
    assert process_time() - begun_s < MOST_S
