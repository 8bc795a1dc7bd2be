"""The table has the state at each time of its grid, and numbers that are the same when they are read."""

import csv
from fractions import Fraction
from io import BytesIO, StringIO
from itertools import pairwise

import pytest
from exported_bench import opened, recorded

from hil.core.kinds.mechaduino.kind import KIND
from hil.recorded.exports.csv_table import csv_lines, write_csv
from hil.recorded.exports.export_names import wanted_fields
from hil.recorded.recorded_run import RecordedRun
from hil.sim.input_log import InputLog
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs


@pytest.fixture(scope="module")
def log() -> InputLog:
    return recorded()


def test_each_row_is_the_state_then(log: InputLog) -> None:
    names = ["m1.r", "s1.position_deg", "m1.e", "s1.pulses", "m2.mode"]
    run, _ = opened(log)
    fields = wanted_fields(run, names)
    file = BytesIO()
    count = write_csv(file, run, fields, SimTimeNs(4 * NS_PER_S + 1), SimTimeNs(5 * NS_PER_S), 7 * NS_PER_MS)
    rows = [*csv.reader(StringIO(file.getvalue().decode()))]
    assert rows[0] == ["at_s", "m1.r [deg]", "m1.e [deg]", "s1.position_deg", "s1.pulses [pulse]", "m2.mode"]
    assert count == len(rows) - 1 == (5000 // 7) - (4000 // 7)
    other = RecordedRun(log)
    for row in rows[1::10]:
        seconds, _, parts = row[0].partition(".")
        at_ns = int(seconds) * NS_PER_S + int(parts)
        assert at_ns % (7 * NS_PER_MS) == 0
        other.run_until(SimTimeNs(at_ns))
        m1, s1, m2 = map(other.runtime.snapshot, ("m1", "s1", "m2"))
        read = [float(each) for each in row[1:]]
        assert read[:2] == [pytest.approx(m1.r, rel=1e-8), pytest.approx(m1.e, rel=1e-8)]
        assert read[2:] == [s1.position_deg, s1.pulses, m2.mode]


def test_each_control_step_has_a_row(log: InputLog) -> None:
    run, _ = opened(log)
    fields = wanted_fields(run, ["m1.control_steps"])
    interval_ns = KIND.control_step_ns
    assert interval_ns == Fraction(7385 * NS_PER_S, 48_000_000)
    text = "".join(csv_lines(run, fields, SimTimeNs(5 * NS_PER_S), SimTimeNs(6 * NS_PER_S), interval_ns))
    steps = [int(line.split(",")[1]) for line in text.splitlines()[1:]]
    assert len(steps) in (6499, 6500)
    assert {later - earlier for earlier, later in pairwise(steps)} == {1}


def test_fields_by_default_are_those_of_each_kind(log: InputLog) -> None:
    run, _ = opened(log)
    names = [str(each) for each in wanted_fields(run, [])]
    assert names[:3] == ["m1.r", "m1.yw", "m1.u"]
    assert "s1.speed_rpm" in names
    assert [str(each) for each in wanted_fields(run, ["s1", "m1.e", "s1"])] == [
        "s1.speed_rpm",
        "s1.commanded_deg",
        "s1.position_deg",
        "m1.e",
    ]
