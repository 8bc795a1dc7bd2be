"""A bench that a program holds: its lease is renewed, given back, and lost aloud."""

import threading
from collections.abc import Sequence
from typing import Any, cast

import pytest

from hil.client import Bench, ClientError, CommandError
from hil.client.held_bench import held


class Leased:
    """Bench whose lease is renewed so often, as answers say."""

    name = "press"

    def __init__(self, *renewals: Exception | None) -> None:
        self.said: list[str] = []
        self._renewals = list(renewals)
        self.is_done = threading.Event()

    def lease(self, why: str, *, for_s: float, doors: Sequence[str] = ()) -> None:
        self.said.append(f"take {why} {for_s} {list(doors)}")

    def renew_lease(self, *, for_s: float) -> None:
        self.said.append(f"renew {for_s}")
        answer = self._renewals.pop(0) if self._renewals else None
        if not self._renewals:
            self.is_done.set()
        if answer:
            raise answer

    def give_lease(self) -> None:
        self.said.append("give")


def use(bench: Leased, held_s: float, *, fails: bool = False) -> None:
    with held(cast(Bench, cast(Any, bench)), "tests", doors=["ports"], held_s=held_s):
        if bench._renewals:
            assert bench.is_done.wait(60)
        if fails:
            raise KeyError("press")


def test_it_is_given_back_also_after_an_error() -> None:
    bench = Leased()
    with pytest.raises(KeyError):
        use(bench, 1000, fails=True)
    assert bench.said == ["take tests 1000 ['ports']", "give"]


def test_it_is_renewed_also_after_a_link_that_was_away() -> None:
    bench = Leased(ClientError("nobody answers"), None)
    use(bench, 0.04)
    assert bench.said[:3] == ["take tests 0.04 ['ports']", "renew 0.04", "renew 0.04"]
    assert bench.said[-1] == "give"


def test_one_that_was_broken_is_not_given_back_and_said() -> None:
    bench = Leased(CommandError("not_now", "there is no lease to renew; it may have ended"))
    with pytest.warns(UserWarning, match="press was no more ours: .*there is no lease to renew"):
        use(bench, 0.04)
    assert "give" not in bench.said
