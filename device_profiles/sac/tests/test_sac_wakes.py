"""Wakes of a sketch that reads the SAC's packets: when each comes, and that no byte is lost."""

from device_profiles.sac.framing import FRAMING
from hil.sim.uart import UART_BUFFER_BYTES, DeviceUart
from hil.vocab.time import FOREVER, SimTimeNs

T0 = 123_456_789


def character_end_ns(n: int, baud: int) -> int:
    """Time at which character n (from 1) ends."""
    return T0 + n * 10 * 10**9 // baud


def uart(baud: int) -> DeviceUart:
    made = DeviceUart(baud, lambda at_ns, data: None)
    made.now_ns = SimTimeNs(T0)
    return made


MS_BAUD = 10_000
"""Speed at which a character takes a millisecond."""


def marked() -> DeviceUart:
    line = uart(MS_BAUD)
    line.wake_on(FRAMING)
    line.polls_from_ns = SimTimeNs(T0)
    return line


def wakes(line: DeviceUart) -> list[int]:
    """Numbers of the characters that the sketch is woken for, from 1 on."""
    numbers = []
    while (at_ns := line.incoming.next_ns) < FOREVER:
        numbers.append((at_ns - T0) // 10**6)
        line.now_ns = at_ns
        line.take_arrivals()
    return numbers


def test_only_a_byte_behind_its_mark_wakes_once_what_stands_before_is_known() -> None:
    line = marked()
    line.hear(SimTimeNs(T0), b"\2\0\5x\3\2\0\2\0x", MS_BAUD)
    line.hear(SimTimeNs(character_end_ns(10, MS_BAUD)), b"\0\0x\3", MS_BAUD)
    line.hear(SimTimeNs(character_end_ns(14, MS_BAUD)), b"c\0", MS_BAUD)
    assert wakes(line) == [2, 7, 16]  # 2: what stands before the first is not known
    assert line.read_all() == b"\2\0\5x\3\2\0\2\0x\0\0x\3c\0"


def test_a_byte_right_behind_its_mark_wakes_and_one_behind_that_does_not() -> None:
    line = marked()
    line.hear(SimTimeNs(T0), b"xx\3\0\0\3\3\0\3", MS_BAUD)
    line.hear(SimTimeNs(character_end_ns(9, MS_BAUD)), b"\0\0", MS_BAUD)
    assert wakes(line) == [4, 8, 10]


def test_every_such_byte_wakes_while_the_sketch_does_not_poll_and_after_an_overrun() -> None:
    line = marked()
    line.hear(SimTimeNs(T0), b"xxxx\0", MS_BAUD)
    assert wakes(line) == []
    line.incoming.loosen()
    assert wakes(line) == [5]
    line.polls_from_ns = FOREVER
    line.incoming.wakes.tighten()
    line.hear(SimTimeNs(character_end_ns(5, MS_BAUD)), b"x" * 70 + b"\0\3x\0x\0", MS_BAUD)
    line.hear(SimTimeNs(character_end_ns(81, MS_BAUD)), b"xxx\0", MS_BAUD)
    assert wakes(line) == [79, 81, 85]
    assert line.overrun_bytes == 85 - UART_BUFFER_BYTES
