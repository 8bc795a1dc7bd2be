"""Random operations at a port of a bench in memory and at the pty of a live one: the same results.

``HIL_FUZZ`` sets how many operations are tried (1,500; ``make fuzz``: 100,000). Times are not compared. Where
results differ after the pty's time-out was over, all is tried again with a longer one: beside other load, the
wall's 2 ms are over between two bytes that are both there. What differs by intent is left out:

- writes beyond what a pty and a board hold, and ``out_waiting``: a port in memory takes all at once;
- XON and XOFF: stopped, and without a write time-out, pyserial tries again without an end;
- formats but 8 data bits without parity: a pty refuses them or does not tell them, depending on what else is
  set; a port in memory garbles, as a UART.
"""

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import serial
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hil.testing import Bench, live

pytestmark = pytest.mark.long

OPERATIONS = int(os.environ.get("HIL_FUZZ", "1500"))
MOST = 40
PATIENCE_S = 60.0
SHORT_S, LONG_S = 0.002, 0.2
BOARD = """
from hil.vocab.firmware import ByteAvailable
from hil.vocab.profile import Profile


class Echo:
    def __init__(self, board):
        self._uart = board.uart

    def main(self):
        while True:
            yield ByteAvailable()
            self._uart.write(self._uart.read_all())

    def interrupt(self, event):
        pass


PROFILE = Profile(firmware=Echo)
"""

Call = Callable[[serial.Serial], Any]


class Preempted(AssertionError):
    """Results that differ, after the time-out of the pty was over."""


class Waits:
    """Time-out of operations that wait for a short time."""

    short_s = SHORT_S


class Operation(NamedTuple):
    """Operation at one of two handles of a port. ``name``: for people."""

    name: str
    handle: int
    call: Call


def set_to(name: str, value: Any) -> Call:
    return lambda port: setattr(port, name, value)


def read_into(size: int) -> Call:
    def call(port: serial.Serial) -> tuple[int, bytes]:
        data = bytearray(size)
        return port.readinto(data), bytes(data)

    return call


def told_lines(port: serial.Serial) -> list[bytes]:
    return [line for line, _ in zip(port, range(3), strict=False)]


def through_text(port: serial.Serial) -> Any:
    port.apply_settings(port.get_settings())
    return {name: value for name, value in port.get_settings().items() if name != "baudrate"}


SIZES = st.integers(0, 12)
DATA = st.binary(max_size=12).map(lambda data: data.translate(None, b"\x11\x13")) | st.just(b"ok\r\n")
PLAIN: dict[str, Call] = {
    "read_all": lambda port: port.read_all(),
    "in_waiting": lambda port: port.in_waiting,
    "reset_input_buffer": lambda port: port.reset_input_buffer(),
    "reset_output_buffer": lambda port: port.reset_output_buffer(),
    "flush": lambda port: port.flush(),
    "cancel_read": lambda port: port.cancel_read(),
    "cancel_write": lambda port: port.cancel_write(),
    "send_break": lambda port: port.send_break(),
    "break on": set_to("break_condition", True),
    "break off": set_to("break_condition", False),
    "cts": lambda port: port.cts,
    "ri": lambda port: port.ri,
    "dtr": set_to("dtr", False),
    "rts": set_to("rts", True),
    "readline": lambda port: port.readline(),
    "readlines": lambda port: port.readlines(),
    "lines": told_lines,
    "settings": through_text,
    "open": lambda port: port.open(),
    "close": lambda port: port.close(),
    "is_open": lambda port: (port.is_open, port.readable(), port.writable(), port.seekable()),
    "text": lambda port: port.write("text"),
    "nothing": lambda port: port.write(None),
    "numbers": lambda port: port.write([1, 2, 300]),
    "unlock": set_to("exclusive", None),
    "lock": set_to("exclusive", True),
    "input off": lambda port: port.set_input_flow_control(False),
    "input on": lambda port: port.set_input_flow_control(True),
}
CALLS = st.one_of(
    st.sampled_from(sorted(PLAIN)).map(lambda name: (name, PLAIN[name])),
    DATA.map(lambda data: (f"write {data!r}", lambda port: port.write(data))),
    DATA.map(lambda data: (f"write {data!r}", lambda port: port.write(bytearray(data)))),
    SIZES.map(lambda size: (f"read {size}", lambda port: port.read(size))),
    SIZES.map(lambda size: (f"readinto {size}", read_into(size))),
    SIZES.map(lambda size: (f"readline {size}", lambda port: port.readline(size))),
    st.sampled_from([b"\n", b"ok", b"", b"\0"]).map(
        lambda end: (f"read_until {end!r}", lambda port: port.read_until(end, 9))
    ),
    st.sampled_from([0, -1, "x"]).map(lambda value: (f"timeout {value}", set_to("timeout", value))),
    st.just(("timeout short", lambda port: setattr(port, "timeout", Waits.short_s))),
    st.sampled_from([0, 2, None]).map(
        lambda value: (f"write_timeout {value}", set_to("write_timeout", value))
    ),
    st.sampled_from([None, 0.1]).map(
        lambda value: (f"inter_byte_timeout {value}", set_to("inter_byte_timeout", value))
    ),
    st.sampled_from([9600, 115200, 12345, 250_000, 50, 0, -1, "x"]).map(
        lambda value: (f"baudrate {value}", set_to("baudrate", value))
    ),
    st.sampled_from([8, 9]).map(lambda value: (f"bytesize {value}", set_to("bytesize", value))),
    st.sampled_from("NX").map(lambda value: (f"parity {value}", set_to("parity", value))),
    st.sampled_from([1, 1.5, 2, 3]).map(lambda value: (f"stopbits {value}", set_to("stopbits", value))),
    st.booleans().map(lambda value: (f"rtscts {value}", set_to("rtscts", value))),
)
OPERATIONS_LIST = st.lists(
    st.tuples(CALLS, st.sampled_from([0, 0, 0, 1])).map(
        lambda each: Operation(each[0][0], each[1], each[0][1])
    ),
    min_size=MOST // 2,
    max_size=MOST,
)


def result_of(call: Call, port: serial.Serial) -> tuple[str, Any]:
    """Result, or the error's class and number."""
    try:
        return "answer", call(port)
    except Exception as error:
        return type(error).__name__, getattr(error, "errno", None)


def waiting(ports: list[serial.Serial]) -> int | None:
    """Number of bytes that have come; None: nobody has the port open."""
    return next((port.in_waiting for port in ports if port.is_open), None)


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    boards = tmp_path_factory.mktemp("boards")
    (boards / "echo").mkdir()
    (boards / "echo" / "__init__.py").touch()
    (boards / "echo" / "board.py").write_text(BOARD)
    (boards / "echo" / "profile.yaml").write_text("# Echo.\nname: echo\ntitle: Echo\nuarts:\n  main: {}\n")
    return {"bench": "b", "profile_path": [str(boards)], "devices": {"e1": {"profile": "echo"}}}


@pytest.fixture(scope="module")
def pty(config: dict[str, Any]) -> Iterator[str]:
    with live(config) as bench:
        yield str(Path(bench.port("e1")).resolve())


@pytest.fixture(scope="module")
def bench(config: dict[str, Any]) -> Iterator[Bench]:
    with Bench(config) as made:
        made.start()
        yield made


@pytest.mark.thorough
@settings(
    max_examples=max(1, OPERATIONS // MOST),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(operations=OPERATIONS_LIST)
def test_a_port_in_memory_does_as_a_pty(bench: Bench, pty: str, operations: list[Operation]) -> None:
    Waits.short_s = SHORT_S
    try:
        compare(bench, pty, operations)
    except Preempted:
        Waits.short_s = LONG_S
        compare(bench, pty, operations)


def compare(bench: Bench, pty: str, operations: list[Operation]) -> None:
    short_s = Waits.short_s
    ours = [bench.serial("e1", timeout=short_s, write_timeout=2) for _ in range(2)]
    theirs = [serial.Serial(pty, 115200, timeout=short_s, write_timeout=2) for _ in range(2)]
    try:
        for number, (name, handle, call) in enumerate(operations):
            told = f"{number}: {name} at {handle}"
            expected = result_of(call, ours[handle])
            start_s = time.monotonic()
            found = result_of(call, theirs[handle])
            was_over = time.monotonic() - start_s >= short_s == SHORT_S
            if found != expected and was_over:
                raise Preempted(told)
            assert expected == found, told
            bench.run(2)
            held, end_s = waiting(ours), time.monotonic() + PATIENCE_S
            while waiting(theirs) != held and time.monotonic() < end_s:
                time.sleep(0.0002)
            assert waiting(theirs) == held, told
    finally:
        for port in (*ours, *theirs):
            with contextlib.suppress(OSError):
                port.close()
