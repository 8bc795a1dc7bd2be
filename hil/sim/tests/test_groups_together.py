"""Groups in virtual time: whose firmware runs when."""

from typing import Any

import pytest

from hil.core.abi import Lanes
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, NS_PER_S

BOARDS = 6
CONFIG = {
    "bench": "together",
    "devices": {
        f"m{number}": {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
        for number in range(BOARDS)
    },
}


def turns(lanes: Lanes) -> list[tuple[int, str]]:
    """Times and boards of what boards say while all are spoken to at once."""
    found: list[tuple[int, str]] = []
    with Bench(CONFIG) as bench:
        runtime = bench._runtime
        runtime.core.native.set_lanes(lanes)
        bench.run_until(4500)
        for name, device in runtime.devices.items():
            group = runtime.parts.group_of(name)

            def said(*_: Any, name: str = name, group: Any = group) -> None:
                found.append((group.now_ns, name))

            device.uarts[""].listeners.append(said)
        for turn in range(5):
            for name in reversed(runtime.devices):
                bench.port(name).write(b"yxps" if name != "m2" else b"psyx"[turn % 4 :])
            bench.run(40 * turn)
        bench.run(1500)
    return found


def test_firmwares_run_in_the_order_of_times_and_then_of_devices() -> None:
    found = turns(Lanes.any)
    assert len(found) > 10 * BOARDS
    assert len({at_ns for at_ns, _ in found}) > 20
    assert found == sorted(found)


def test_the_order_is_the_same_with_any_lanes() -> None:
    assert turns(Lanes.none) == turns(Lanes.any)


def test_a_day_of_rest_takes_no_time() -> None:
    with Bench(CONFIG) as bench:
        bench.run_until(4500)
        calls = 0
        native = bench._runtime.core.native

        class Counted:
            def __getattr__(self, name: str) -> Any:
                nonlocal calls
                calls += 1
                return getattr(native, name)

        bench._runtime.core.native = Counted()  # type: ignore[assignment]
        bench.run(86_400_000)
        assert bench.now_ns == 86_400 * NS_PER_S + 4500 * NS_PER_MS
        assert {bench.axis(name).snapshot().at_ns for name in CONFIG["devices"]} == {bench.now_ns}
        assert calls < 50


@pytest.mark.parametrize("name", ["m0", "m3"])
def test_a_board_that_hears_something_in_between_is_not_ahead(name: str) -> None:
    """Bytes between two runs reach a board at their time, wherever the others are."""
    with Bench(CONFIG) as bench, Bench(CONFIG) as other:
        for each in (bench, other):
            each.run_until(4500)
            each.port(name).write(b"yx")
        bench.run(300)
        for _ in range(300):
            other.run(1)
        assert bench.port(name).read_complete() == other.port(name).read_complete()
        for axis in CONFIG["devices"]:
            assert bench.axis(axis).snapshot() == other.axis(axis).snapshot()
