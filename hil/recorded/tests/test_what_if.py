"""A recorded run with something changed: exact where it makes no difference, and where the runs part."""

from dataclasses import replace
from io import StringIO

import pytest

from hil.config import ConfigError
from hil.recorded.log_changes import ChangeRefused
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.what_if import DIFFERENCE, NOW, THEN, changed_run, told_fields
from hil.sim.input_log import InputLog
from hil.sim.inputs import Do, Logged
from hil.sim.log_reading import read_input_log
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, SimTimeNs

CONFIG = {
    "bench": "two",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}, "plant": "full"},
        "s1": {"profile": "sac", "plant": "full"},
    },
}
MOVE_NS, FAULT_NS = SimTimeNs(4500 * NS_PER_MS), SimTimeNs(5500 * NS_PER_MS)


@pytest.fixture(scope="module")
def log() -> InputLog:
    """Log of a run with a move of m1, a fault on it later, and a calibration that writes the memory."""
    with Bench(CONFIG) as bench:
        bench.start()
        for at_ms, text in ((4100, b"x"), (4200, b"y"), (4500, b"r\r90\r"), (5000, b"k")):
            bench.run(at_ms - bench.now_ns / NS_PER_MS)
            bench.port("m1").write(text)
        bench.run(FAULT_NS / NS_PER_MS - bench.now_ns / NS_PER_MS)
        bench.fault("shaft_load", "m1", torque_Nm=0.05)
        bench.run(600)
        bench.port("s1").write(b"?\r")
        bench.run(400)
        text_file = StringIO()
        bench.inputs.write_to(text_file)
    return read_input_log(text_file.getvalue().splitlines(keepends=True))


@pytest.mark.parametrize(
    "settings",
    [
        ["m1.pKp=15"],
        ["m1.axis.inertia_kg_m2={inertia_kg_m2}"],
        ["seed=0"],
        ["m1.plant=full"],
        ["s1.baud=38400"],
        ["m1.flash.table=identity"],
    ],
)
def test_a_value_that_it_has_makes_no_difference(log: InputLog, settings: list[str]) -> None:
    run = RecordedRun(log)
    profile = run.catalogue.profiles["mechaduino"]
    has = run.config.devices["m1"].axis_parameters(profile)
    asked = changed_run(run, [text.format_map(has) for text in settings])
    found = asked.parting()
    assert found.first_ns is None, (found.at_ns, found.fields, found.sent)
    assert not asked.left_out


def test_a_gain_parts_the_runs_where_the_loop_has_an_error(log: InputLog) -> None:
    asked = changed_run(RecordedRun(log), ["m1.pKp=10"])
    found = asked.parting()
    assert found.first_ns is not None
    assert 4200 * NS_PER_MS <= found.first_ns < MOVE_NS + 10 * NS_PER_MS
    assert ("m1", "u") in {(each.axis, each.name) for each in found.fields}
    assert not any(each.name == "pKp" or each.axis == "s1" for each in found.fields)
    before, after = asked.then(), asked.then()
    before.run_until(SimTimeNs(found.first_ns - 1))
    after.run_until(found.first_ns)
    now = asked.now()
    now.run_until(SimTimeNs(found.first_ns - 1))
    assert before.runtime.snapshot("m1").u == now.runtime.snapshot("m1").u
    now.run_until(found.first_ns)
    assert after.runtime.snapshot("m1").u != now.runtime.snapshot("m1").u


def test_a_gain_can_be_set_later(log: InputLog) -> None:
    found = changed_run(RecordedRun(log), ["m1.pKp=10"], at_ns=MOVE_NS).parting()
    assert found.first_ns is not None
    assert MOVE_NS <= found.first_ns < MOVE_NS + 50 * NS_PER_MS


def test_a_plant_changes_the_motion_and_both_are_series(log: InputLog) -> None:
    asked = changed_run(RecordedRun(log), ["m1.axis.inertia_kg_m2=5e-5"])
    found = asked.parting()
    fields = [*told_fields(asked.then(), found)]
    assert fields[0] == RunField("m1", "e")
    end_ns = SimTimeNs(MOVE_NS + 100 * NS_PER_MS)
    series = asked.series(fields, MOVE_NS, end_ns, NS_PER_MS)
    then, now, difference = series[THEN], series[NOW], series[DIFFERENCE]
    assert then.signals == ("m1.e", "m1.position_deg")
    assert [row[0] for row in difference.rows] == [*range(MOVE_NS, end_ns + 1, NS_PER_MS)]
    at = next(i for i, row in enumerate(difference.rows) if abs(row[2]) > 1)
    assert difference.rows[at][2] == now.rows[at][2] - then.rows[at][2]
    assert difference.unit("m1.e") == "deg"


def test_a_fault_is_left_out_or_added(log: InputLog) -> None:
    for without in ("all", "1", "shaft_load"):
        found = changed_run(RecordedRun(log), without=[without]).parting()
        assert found.first_ns is not None
        assert FAULT_NS <= found.first_ns < FAULT_NS + NS_PER_MS
    asked = changed_run(RecordedRun(log), faults=["shaft_load m1 torque_Nm=0.05 at=4.8s for=100ms"])
    found = asked.parting()
    assert found.at_ns is not None
    assert 4800 * NS_PER_MS <= found.at_ns < 4801 * NS_PER_MS
    moved = changed_run(RecordedRun(log), faults=["shaft_load m1 torque_Nm=0.05 at=5.5s"], without=["all"])
    assert moved.parting().first_ns is None


def test_bytes_that_differ_are_told_with_their_place(log: InputLog) -> None:
    found = changed_run(RecordedRun(log), ["s1.baud=9600"]).parting()
    first = next(each for each in found.sent if each.place == "s1")
    assert first.then
    assert first.now
    assert first.then != first.now


def test_inputs_that_make_no_sense_any_more_are_counted(log: InputLog) -> None:
    enabled = Logged(FAULT_NS, "m1", Do("enable"))
    more = replace(log, inputs=[*log.inputs, enabled], lines=[*log.lines, 14])
    asked = changed_run(RecordedRun(more), ["m1.profile=sac"])
    assert asked.parting().sent
    assert [*asked.left_out] == [len(log.inputs)]
    assert "a sac has no verb 'enable'" in asked.left_out[len(log.inputs)]


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("m1.pKq=1", 'did you mean "m1.pKp"'),
        ("m1.inertia_kgm2=1", 'did you mean "m1.axis.inertia_kg_m2"'),
        ("m3.pKp=1", "there are m1, s1, seed"),
        ("m1.pKp=99999999", "m1.pKp: 99999999 is too large; write"),
        ("m1.pKp=high", 'm1.pKp: "high" is no number; write'),
        ("m1.pKp", "write it as in m1.pKp=10"),
        ("m1=3", "names nothing"),
    ],
)
def test_settings_that_name_nothing(log: InputLog, setting: str, said: str) -> None:
    with pytest.raises(ChangeRefused, match=said):
        changed_run(RecordedRun(log), [setting])


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("m1.axis.inertia_kgm2=1", "inertia_kg_m2"),
        ("m1.axis.inertia_kg_m2=-1", "inertia_kg_m2"),
        ("m1.baud=fast", "whole number"),
    ],
)
def test_keys_are_checked_as_a_configuration(log: InputLog, setting: str, said: str) -> None:
    asked = changed_run(RecordedRun(log), [setting])
    with pytest.raises(ConfigError, match=said):
        asked.now()


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("shaft_lod m1 torque_Nm=1", 'did you mean "shaft_load"'),
        ("shaft_load m9 torque_Nm=0.1", "there is no 'm9'"),
        ("shaft_load m1 torque=0.1", "torque"),
        ("shaft_load", "write it as in"),
    ],
)
def test_faults_that_cannot_be(log: InputLog, fault: str, said: str) -> None:
    with pytest.raises(ChangeRefused, match=said):
        changed_run(RecordedRun(log), faults=[fault])
    with pytest.raises(ChangeRefused, match="there are: 1 shaft_load"):
        changed_run(RecordedRun(log), without=["2"])
