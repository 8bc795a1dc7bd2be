"""Master of Modbus in a process of its own beside a running bench, at a pty and over tcp."""

import asyncio
from collections.abc import Iterator

import pytest

from bridges.modbus.master import UnitPoll, open_modbus_line
from bridges.modbus.protocol.client_side import read, write
from bridges.modbus.protocol.pdu import Table
from hil.master import LineGone, LineUnreachable, Outcome
from hil.testing import ServedBench, live

pytestmark = pytest.mark.long
PATIENCE_S = 60
LOAD = 1024  # load_torque_Nm, a float of 64 bits
INPUTS, HOLDING = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS
CONFIG = {
    "bench": "plant",
    "devices": {name: {"profile": "mechaduino"} for name in ("m1", "m2")},
    "segments": {
        "bus0": {
            "modbus": {"units": {"m1": 1, "m2": 2}},
            "baud": 38400,
            "taps": {"master": {"port": "pty"}, "net": {"port": "tcp"}},
        }
    },
}


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(CONFIG) as made:
        yield made


def polls() -> list[UnitPoll]:
    return [UnitPoll(unit, read(INPUTS, 0, 2)) for unit in (1, 2)]


@pytest.mark.parametrize("tap", ["bus0.master", "bus0.net"])
def test_units_are_polled_and_a_write_goes_in_between(bench: ServedBench, tap: str) -> None:
    async def run() -> None:
        units, seen = polls(), []
        runtime_dir = bench.folder / "run"
        async with (
            asyncio.timeout(PATIENCE_S),
            open_modbus_line(
                tap, units, runtime_dir=runtime_dir, polled=lambda poll: seen.append(poll.unit)
            ) as line,
        ):
            await line.polled(2)
            assert (await line.ask(1, write(HOLDING, LOAD, (0, 0, 0, 0)))).outcome is Outcome.DONE
            asked = await line.ask(2, read(HOLDING, LOAD, 4))
            assert asked.outcome is Outcome.DONE
            assert asked.answer.values == (0, 0, 0, 0)
            await line.polled(1)
        assert seen[:4] == [1, 2, 1, 2]
        assert [len(poll.answer.values) for poll in units if poll.answer] == [2, 2]

    asyncio.run(run())


def test_a_unit_that_is_not_there_is_missed_and_a_write_to_it_is_not_known(bench: ServedBench) -> None:
    async def run() -> None:
        missing = UnitPoll(9, read(INPUTS, 0, 2))
        units = [*polls(), missing]
        async with (
            asyncio.timeout(PATIENCE_S),
            open_modbus_line("bus0.net", units, runtime_dir=bench.folder / "run") as line,
        ):
            await line.polled(1)
            asked = await line.ask(9, write(HOLDING, LOAD, (0, 0, 0, 0)))
        assert (asked.outcome, asked.sent) == (Outcome.NOT_KNOWN, 1)
        assert missing.missed >= 1
        assert missing.answer is None

    asyncio.run(run())


def test_a_tap_that_is_not_there(bench: ServedBench) -> None:
    async def run() -> None:
        async with open_modbus_line("bus0.mastr", runtime_dir=bench.folder / "run"):
            pass

    with pytest.raises(LineUnreachable, match=r"no tap 'bus0.mastr' .*bus0.master"):
        asyncio.run(run())


def test_a_bench_that_ends_is_told_with_what_was_outstanding() -> None:
    async def run(bench: ServedBench) -> None:
        async with (
            asyncio.timeout(PATIENCE_S),
            open_modbus_line("bus0.net", polls(), runtime_dir=bench.folder / "run") as line,
        ):
            await line.polled(1)
            await asyncio.to_thread(bench.ask, "stop")
            await line.polled(1_000_000)

    with live(CONFIG) as made, pytest.raises(LineGone, match=r"bus0\.net has gone"):
        asyncio.run(run(made))
