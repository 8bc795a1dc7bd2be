"""Forms of answers: what another program may say without a command's mistake."""

import pytest

from hil.net.answers import misfit

RUN = {
    "run": "r",
    "state": "done",
    "step": 1,
    "steps": 1,
    "submissions": 1,
    "planned_end_ns": None,
    "why": None,
    "axes": {},
    "benches": {},
}


@pytest.mark.parametrize("answer", [RUN, {"run": "r", "steps": 1}, {"problems": "r.yaml:1:1: none"}])
def test_a_run_is_answered_in_three_ways(answer: dict[str, object]) -> None:
    assert not misfit("run", answer)


@pytest.mark.parametrize("key", sorted(RUN.keys() - {"state", "steps", "run"}))
def test_a_run_without_one_of_its_keys_is_no_answer_to_a_check(key: str) -> None:
    assert misfit("run", {name: value for name, value in RUN.items() if name != key})
