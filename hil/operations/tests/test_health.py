"""The three words for how a bench is."""

import pytest

from hil.host.real_time import Grant, is_asked
from hil.operations.health import KINDS, lateness, state_of
from hil.vocab.monitoring import LATE_KINDS, HealthProblem

REFUSED = Grant(80, 1, {"real-time priority": "a remedy"})
UNASKED = Grant(80, 1, {"real-time priority": "a remedy"}, is_asked=False)
GRANTED = Grant(80, 1, {})


@pytest.mark.parametrize(
    ("grant", "missed_share", "worst_ms", "kinds"),
    [
        (UNASKED, 0.4, 1000, []),
        (UNASKED, 0.4, 1001, ["loop"]),
        (GRANTED, 0.01, 250, []),
        (GRANTED, 0.011, 251, ["wakes", "loop"]),
        (REFUSED, 0.0, 0, ["real_time"]),
    ],
)
def test_lateness_is_a_finding_for_who_asked_for_real_time(
    grant: Grant, missed_share: float, worst_ms: int, kinds: list[str]
) -> None:
    found = list(lateness(grant, missed_share, worst_ms * 1_000_000))
    assert [problem.kind for problem in found] == kinds
    assert state_of(found) == ("late" if kinds else "ok")


def test_what_does_not_work_outweighs_lateness() -> None:
    for kind in KINDS:
        problems = [HealthProblem("loop", "", "late", "wait"), HealthProblem(kind, "m1", "x", "y")]
        assert state_of(problems) == ("late" if kind in LATE_KINDS else "failed")
    assert set(LATE_KINDS) < set(KINDS)


def test_who_asks_for_real_time(monkeypatch: pytest.MonkeyPatch) -> None:
    for limit in (0, 80):
        monkeypatch.setattr("resource.getrlimit", lambda _, limit=limit: (limit, limit))
        assert is_asked(None, False) is (limit > 0)
        assert is_asked(0, False)
        assert is_asked(None, True)
