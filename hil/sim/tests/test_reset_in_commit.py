"""A reset while the memory is being written: nobody is told of another's commit, and nothing is forgotten."""

from collections.abc import Callable, Mapping

import pytest
from session_bench import PARAMETERS

from hil.core import Core
from hil.sim.bench import VIRTUAL, BenchRuntime
from hil.sim.hardware import DeviceSpec
from hil.sim.inputs import Bytes, CommitDone, Reset
from hil.sim.twin import Twin
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.firmware import MAIN, Board, ByteAvailable, Commit, CoreEvent, Main
from hil.vocab.time import SimTimeNs

MS = 1_000_000


class SlowStore:
    """Answers nothing by itself."""

    def __init__(self) -> None:
        self.asked: list[dict[str, bytes]] = []
        self.answered: list[Callable[[bool], bool]] = []

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        self.asked.append(dict(sections))
        self.answered.append(answered)
        return None


class Keeper:
    """Says at boot what it remembers; stores each byte it gets under its name, and says what came of it."""

    def __init__(self, board: Board) -> None:
        self.uart, self.nvm = board.uart, board.nvm

    def main(self) -> Main:
        self.uart.write(b"boot:" + b"".join(sorted(self.nvm.values())) + b"\n")
        while True:
            yield ByteAvailable()
            byte = bytes([self.uart.read()])
            durable: bool = yield Commit(byte.decode(), byte)
            self.uart.write(byte + (b" kept\n" if durable else b" failed\n"))

    def interrupt(self, event: CoreEvent) -> None:
        return


class Bench:
    """A ``Keeper`` on the virtual clock."""

    def __init__(self) -> None:
        self.store = SlowStore()
        self.runtime = BenchRuntime("test", Core(2), self.store, VIRTUAL)
        self.heard = b""
        group = self.runtime.open_group()
        spec = DeviceSpec(
            name="m1", profile="t", firmware=Keeper, bauds={MAIN: None}, nvm={}, power_up={}, facts={}
        )
        self.device = self.runtime.make(spec, {"axis": AxisPlan(PARAMETERS, law="mechaduino")}, group)
        self.device.uarts[MAIN].listeners.append(self._hear)
        self.runtime.add(group, self.device)
        self.runtime.advance(SimTimeNs(MS))

    def _hear(self, at_ns: SimTimeNs, data: bytes) -> None:
        self.heard += data

    def give(self, given: Bytes | CommitDone | Reset) -> bytes:
        """Give an input, and return what is sent within 5 ms after it."""
        self.heard = b""
        self.runtime.apply_to(self.device, given)
        self.runtime.advance(SimTimeNs(self.runtime.now_ns + 5 * MS))
        return self.heard


@pytest.mark.parametrize("durable", [True, False])
def test_a_board_starts_again_when_its_write_has_ended(durable: bool) -> None:
    bench = Bench()
    assert bench.give(Bytes(b"a")) == b""
    assert bench.give(Reset()) == b""
    assert bench.give(Bytes(b"b")) == b""
    assert bench.give(CommitDone(durable)) == (b"boot:a\n" if durable else b"boot:\n")
    assert bench.store.asked[1] == ({"a": b"a", "b": b"b"} if durable else {"b": b"b"})
    assert bench.give(CommitDone(True)) == b"b kept\n"
    assert bench.device.nvm == bench.store.asked[-1]


def test_a_write_that_is_answered_late_is_not_taken_for_a_later_one() -> None:
    bench = Bench()
    bench.give(Bytes(b"a"))
    bench.give(Reset())
    bench.give(Reset())
    assert bench.give(CommitDone(False)) == b"boot:\n"
    assert bench.give(Bytes(b"b")) == b""
    assert bench.give(CommitDone(True)) == b"b kept\n"
    assert bench.store.asked == [{"a": b"a"}, {"b": b"b"}]


def test_a_write_goes_on_when_the_power_is_lost() -> None:
    bench = Bench()
    bench.give(Bytes(b"a"))
    bench.device.power.switch("unplugged", bench.runtime.now_ns)
    assert bench.give(CommitDone(True)) == b""
    assert bench.device.nvm == {"a": b"a"}
    assert bench.give(Reset()) == b"", "there is still no power"
    bench.device.power.switch(None, bench.runtime.now_ns)
    bench.runtime.advance(SimTimeNs(bench.runtime.now_ns + MS))
    assert bench.heard == b"boot:a\n"


def test_an_answer_that_nobody_asked_for_changes_nothing() -> None:
    bench = Bench()
    assert bench.give(CommitDone(True)) == b""
    assert bench.give(Bytes(b"a")) == b""
    assert bench.give(CommitDone(True)) == b"a kept\n"


def test_a_store_answers_by_the_call_it_was_given() -> None:
    bench = Bench()
    bench.give(Bytes(b"a"))
    bench.heard = b""
    assert bench.store.answered[0](True)
    assert bench.heard == b"a kept\n"


def test_a_store_is_told_that_nobody_waits_for_its_answer() -> None:
    bench = Bench()
    bench.give(Bytes(b"a"))
    bench.runtime.remove("m1")
    assert not bench.store.answered[0](True)
    assert bench.heard == b""
