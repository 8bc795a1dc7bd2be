"""The runtime's rules, with main programs that are written for one rule each."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.firmware.runtime import FirmwareStuck, Runtime, RxBuffer
from hil.vocab.firmware import ByteAvailable, Commit, Delay, EventAvailable, Main
from hil.vocab.time import FOREVER, SimTimeNs

SECOND = 1_000_000_000


class Line(RxBuffer):
    """A receive buffer; what is written is kept."""

    def __init__(self) -> None:
        super().__init__(64)
        self.written = bytearray()

    def write(self, data: bytes) -> None:
        self.written += data


class Board:
    """A runtime with its surroundings; ``log`` is what the main program notes."""

    def __init__(self, main: Callable[["Board"], Main], print_ns: int = 0) -> None:
        self.uart = Line()
        self.log: list[Any] = []
        self.commits: list[Commit] = []
        self.runtime = Runtime(
            main(self),
            lambda: self.uart.available() > 0,
            self.commits.append,
            lambda now_ns: SimTimeNs(now_ns + print_ns),
        )

    def at(self, now_ns: int) -> int:
        """Resume the program, and return the next time that is due."""
        self.runtime.resume(SimTimeNs(now_ns))
        return self.runtime.due_ns


def delays(board: Board) -> Main:
    board.log.append("start")
    assert (yield Delay(100)) is None
    board.log.append("100")
    yield Delay(0)
    board.log.append("at once")
    yield Delay(50)
    board.log.append("150")
    yield Delay(FOREVER // 2)


def test_delays_end_at_their_exact_times() -> None:
    board = Board(delays)
    assert board.runtime.due_ns == 0
    assert (board.at(0), board.log) == (100, ["start"])
    assert (board.at(99), board.log) == (100, ["start"])
    assert (board.at(100), board.log) == (150, ["start", "100", "at once"])
    board.at(150)
    assert board.log[-1] == "150"


def waits(timeout_ns: int | None) -> Callable[[Board], Main]:
    def main(board: Board) -> Main:
        while True:
            board.log.append((yield ByteAvailable(timeout_ns)))
            if board.uart.available():
                board.log.append(chr(board.uart.read()))

    return main


def test_a_wait_without_limit_has_no_time() -> None:
    board = Board(waits(None))
    assert board.at(0) == FOREVER
    assert board.at(10**15) == FOREVER
    assert board.log == []
    board.uart.feed(b"ab")
    assert board.at(10**15 + 1) == FOREVER
    assert board.log == [True, "a", True, "b"]


def test_a_byte_that_is_there_already_answers_at_once() -> None:
    board = Board(waits(SECOND))
    board.uart.feed(b"x")
    assert board.at(5) == 5 + SECOND
    assert board.log == [True, "x"]


def test_a_time_out_answers_false_and_a_byte_at_its_end_is_too_late() -> None:
    board = Board(waits(SECOND))
    assert board.at(0) == SECOND
    board.uart.feed(b"x")
    board.at(SECOND - 1)
    assert board.log == [True, "x"]
    assert board.runtime.due_ns == 2 * SECOND - 1
    board.uart.feed(b"y")
    board.at(2 * SECOND - 1)
    # Too late for the wait that ends now; the byte stays for the program to find.
    assert board.log == [True, "x", False, "y"]


def test_a_byte_before_the_first_resume_is_not_lost() -> None:
    board = Board(waits(None))
    board.uart.feed(b"q")
    board.at(0)
    assert board.log == [True, "q"]


def stores(board: Board) -> Main:
    board.log.append((yield Commit("a", b"1")))
    board.log.append((yield Commit("b", b"2")))
    yield Delay(7)
    board.log.append("delayed")
    yield Delay(FOREVER // 2)


def test_a_commit_waits_for_its_answer() -> None:
    board = Board(stores)
    assert board.at(0) == FOREVER
    assert board.commits == [Commit("a", b"1")]
    board.uart.feed(b"bytes do not wake it")
    assert board.at(500) == FOREVER
    assert board.log == []
    board.runtime.commit_done(True)
    board.at(600)
    assert (board.log, board.commits[1:]) == ([True], [Commit("b", b"2")])
    board.runtime.commit_done(False)
    assert board.at(700) == 707
    assert board.log == [True, False]


def listens(board: Board) -> Main:
    for number in range(3):
        yield EventAvailable()
        board.log.append(number)
        yield Delay(10)
    yield EventAvailable()


def test_an_interrupt_ends_a_wait_for_it_alone() -> None:
    board = Board(listens)
    assert board.at(0) == FOREVER
    board.uart.feed(b"bytes do not wake it")
    assert (board.at(50), board.log) == (FOREVER, [])
    board.runtime.interrupted(SimTimeNs(60))
    assert board.runtime.due_ns == 60
    assert (board.at(60), board.log) == (70, [0])
    board.runtime.interrupted(SimTimeNs(65))  # while it waits for something else
    assert board.runtime.due_ns == 70
    assert (board.at(70), board.log) == (FOREVER, [0])


def test_a_commit_may_be_answered_while_it_is_made() -> None:
    board = Board(stores)
    board.runtime._commit = lambda request: board.runtime.commit_done(True)
    assert board.at(3) == 10
    assert board.log == [True, True]


def test_a_slow_line_holds_the_program_up_in_print() -> None:
    # Each request starts when what was printed lets the program go on, here 40 ns later.
    def main(board: Board) -> Main:
        yield Delay(100)
        board.log.append("printed and waited")
        board.log.append((yield ByteAvailable(SECOND)))

    board = Board(main, print_ns=40)
    assert board.at(0) == 40
    assert board.at(40) == 140
    assert board.at(140) == 180
    board.uart.feed(b"x")
    assert (board.at(179), board.log) == (180, ["printed and waited"])
    with pytest.raises(FirmwareStuck, match="returned"):
        board.at(180)
    assert board.log[-1] is True


def test_a_program_that_loops_without_time_is_stuck() -> None:
    def main(board: Board) -> Main:
        while True:
            yield Delay(0)

    with pytest.raises(FirmwareStuck, match="without waiting"):
        Board(main).at(0)


def test_a_program_that_returns_is_stuck() -> None:
    def main(board: Board) -> Main:
        return
        yield

    with pytest.raises(FirmwareStuck, match="returned"):
        Board(main).at(0)


@pytest.mark.parametrize("nonsense", [None, 100, "delay", Delay])
def test_a_program_that_yields_anything_else_is_stuck(nonsense: Any) -> None:
    def main(board: Board) -> Main:
        yield nonsense

    with pytest.raises(FirmwareStuck, match=r"which is no request \(test_runtime.py:206\)"):
        Board(main).at(0)


def test_what_a_program_raises_comes_through() -> None:
    def main(board: Board) -> Main:
        yield Delay(1)
        raise ZeroDivisionError("lamp")

    board = Board(main)
    board.at(0)
    with pytest.raises(ZeroDivisionError, match="lamp"):
        board.at(1)


def test_power_off_ends_the_program() -> None:
    def main(board: Board) -> Main:
        try:
            yield Delay(1)
        finally:
            board.log.append("off")

    board = Board(main)
    board.at(0)
    board.runtime.close()
    assert (board.log, board.runtime.due_ns) == (["off"], FOREVER)


REQUESTS = st.lists(
    st.one_of(
        st.integers(0, 1000).map(Delay),
        st.none().map(ByteAvailable),
        st.integers(0, 1000).map(ByteAvailable),
    ),
    max_size=12,
)


@given(REQUESTS, st.lists(st.integers(0, 3000), max_size=8), st.lists(st.integers(0, 5000), max_size=20))
def test_extra_resumes_change_nothing(
    requests: list[Delay | ByteAvailable], bytes_at: list[int], extra: list[int]
) -> None:
    def program(board: Board) -> Main:
        for request in requests:
            answer = yield request
            board.log.append(answer)
            if answer:
                board.log.append(board.uart.read())
        yield Delay(FOREVER // 2)

    def run(extra: list[int]) -> list[Any]:
        board = Board(program)
        events = sorted([(t, 0) for t in bytes_at] + [(t, 1) for t in extra])
        now_ns, seen = 0, []
        board.at(0)
        while events or board.runtime.due_ns < 10**6:
            due_ns = min(board.runtime.due_ns, events[0][0] if events else FOREVER)
            now_ns = max(now_ns, due_ns)
            while events and events[0][0] <= now_ns:
                if events.pop(0)[1] == 0:
                    board.uart.feed(b"z")
            before = len(board.log)
            board.at(now_ns)
            seen += [(now_ns, item) for item in board.log[before:]]
        return seen

    assert run(extra) == run([])
