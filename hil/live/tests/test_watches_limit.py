"""Watches of clients that do not come back for their samples."""

from collections.abc import Iterable
from typing import Any

import pytest

from hil.live import watches as module
from hil.live.watches import Watches
from hil.telemetry import Subscription


class _Bench:
    """Bench whose axes have so many samples at each look."""

    def __init__(self) -> None:
        self.new: dict[str, int] = {}

    def watch(self, axis: str, slot: int, interval_ns: Any, capacity: int, points: int) -> None:
        """Nothing has to be done."""

    def table_names(self, axis: str, fields: Iterable[str]) -> list[str]:
        return list(fields)

    def take_samples(self, axis: str, slot: int) -> tuple[list[bytes], int]:
        return [bytes(8)] * self.new.pop(axis, 0), 0


def test_all_watches_have_a_limit_together(monkeypatch: pytest.MonkeyPatch) -> None:
    import asyncio

    monkeypatch.setattr(module, "MOST_WAITING", 100)

    async def main() -> None:
        bench = _Bench()
        watches = Watches(bench, 1.0, 10.0)  # type: ignore[arg-type]
        numbers = [watches.open(axis, (), 10**9) for axis in "abc"]

        def waiting() -> list[int]:
            queues: list[Subscription] = [watches._open[number].subscription for number in numbers]
            return [each.waiting for each in queues]

        bench.new = {"a": 90, "b": 5, "c": 20}
        watches._poll()
        assert waiting() == [75, 5, 20]
        bench.new = {"b": 80, "c": 80}
        watches._poll()
        assert waiting() == [33, 33, 34]
        assert watches.drain(numbers[2], 1000)[1] == 66
        watches.stop()

    asyncio.run(main())
