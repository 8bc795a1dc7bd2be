"""Times at which steps of a run begin, as its progress has them."""

import pytest

from hil.testing import Bench

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
RUN = {
    "run": "steps",
    "axes": {"m1": {"velocity_rpm": 60.0, "acceleration_rpm_per_s": 600.0}},
    "steps": [{"move": {"m1": 20.0}}, {"move": {"m1": 0.0}}, {"line": {"m1": 7.0}}],
}


@pytest.mark.parametrize("pace", [1.0, 0.4])
def test_each_step_has_its_exact_time_however_late_somebody_looks(pace: float) -> None:
    made = Bench({"bench": "runs", "devices": {"m1": SERVO}})
    made.run(4100)
    made.axis("m1").do("enable")
    execution = made.execute(RUN)
    execution.set_pace(pace)
    found: dict[int, int] = {}
    for until_ns in execution.run():
        made.run_until(until_ns / 1e6)
        progress = execution.progress
        if progress.step not in found and progress.step_at_ns is not None:
            assert progress.step_at_ns <= made.now_ns
            found[progress.step] = progress.step_at_ns
    assert execution.progress.state == "done", execution.progress.why
    (phrase,) = execution.plan.phrases
    marks = [at_ns for at_ns, _ in phrase.marks]
    assert list(found) == [1, 2, 3]
    for step, mark_ns in enumerate(marks, 1):
        assert found[step] - found[1] == pytest.approx(mark_ns / pace, abs=2)
