"""Characters of a program in formats of its own: on a segment, and what others make of them."""

import pytest
from avr_words import (
    DDRD,
    PIND,
    RXC0,
    SERIAL_117647,
    TXC0,
    UCSR0A,
    UCSR0B,
    UDR0,
    ldi,
    lds,
    program,
    rjmp,
    sbi,
    sbis,
    sbrs,
    sts,
)
from test_processor import LINE, axis_of, started_on_line

from hil.testing import Bench

UCSR0C, RESULT = 0xC2, 0x100
FE, UPE, RXB8 = 0x10, 0x04, 0x02
"""Bits of UCSR0A, and of UCSR0B. Source: DS40002061, USART0, Register Description."""
NINE, EIGHTH_SET = 0x04, 0x01
"""UCSZ02 and TXB80 of UCSR0B."""
SENT = 0x53


def in_format(control: int, more: int = 0) -> tuple[tuple[int, ...], ...]:
    """Set-up: UCSR0C, and more bits of UCSR0B."""
    return *SERIAL_117647, *(ldi(16, control), sts(UCSR0C, 16), ldi(16, 0x18 | more), sts(UCSR0B, 16))


def says(control: int, more: int = 0, byte: int = SENT) -> bytes:
    """Program that sends a byte when D3 is high, while D2 is."""
    return program(
        *in_format(control, more),
        *(sbi(DDRD, 2), sbis(PIND, 3), rjmp(-2), ldi(18, byte), sts(UDR0, 18)),
        *(lds(17, UCSR0A), sbrs(17, TXC0), rjmp(-4), rjmp(-1)),
    )


def listens(control: int, more: int = 0) -> bytes:
    """Program that keeps the status, the control register and the byte of what comes first."""
    return program(
        *in_format(control, more),
        *(lds(17, UCSR0A), sbrs(17, RXC0), rjmp(-4), lds(18, UCSR0B), lds(19, UDR0)),
        *(sts(RESULT, 17), sts(RESULT + 1, 18), sts(RESULT + 2, 19), rjmp(-1)),
    )


def told(line: dict[str, object], sender: bytes, receiver: bytes) -> tuple[int, int, int, bytes]:
    """Errors, ninth bit and byte that the receiver has, and what a tap has."""
    with Bench(line) as bench:
        started_on_line(bench, "u1", sender)
        started_on_line(bench, "u2", receiver)
        bench.run(1)
        bench.tap("bus0.tap").read()
        axis_of(bench).pin("D3", 1)
        bench.run(2)
        processor = axis_of(bench, "u2").processor
        assert processor
        status, control, byte = processor.data(RESULT, 3)
        assert status & 1 << RXC0, "nothing came"
        return status & (FE | UPE), control & RXB8, byte, bench.tap("bus0.tap").read()


@pytest.mark.parametrize(
    ("control", "more", "ninth", "byte"),
    [
        (0x26, 0, 0, SENT),  # 8E1
        (0x36, 0, 0, SENT),  # 8O1
        (0x0E, 0, 0, SENT),  # 8N2
        (0x24, 0, 0, SENT),  # 7E1
        (0x00, 0, 0, SENT & 0x1F),  # 5N1
        (0x06, NINE, 0, SENT),
        (0x06, NINE | EIGHTH_SET, RXB8, SENT),
    ],
)
def test_two_of_a_format_understand_each_other(control: int, more: int, ninth: int, byte: int) -> None:
    assert told(LINE, says(control, more), listens(control, more & NINE))[:3] == (0, ninth, byte)


@pytest.mark.parametrize(
    ("sent", "more", "read", "errors"),
    [
        (0x26, 0, 0x36, UPE),  # the other parity
        (0x26, 0, 0x06, FE),  # a parity bit of 0 where a stop bit is looked for
        (0x06, NINE, 0x06, FE),
        (0x06, NINE | EIGHTH_SET, 0x06, 0),
        (0x06, 0, 0x26, UPE),  # a stop bit where the parity bit 0 is looked for
    ],
)
def test_what_does_not_fit_is_an_error(sent: int, more: int, read: int, errors: int) -> None:
    got, _, byte, tapped = told(LINE, says(sent, more), listens(read))
    assert (got, byte) == (errors, SENT)
    assert tapped == bytes((SENT,))


def damaged(line: dict[str, object], sender: bytes) -> list[bool]:
    with Bench(line) as bench:
        started_on_line(bench, "u1", sender)
        seen: list[bool] = []
        bench.runtime.segments["bus0"].watchers.append(lambda event: seen.append(event.is_damaged))
        axis_of(bench).pin("D3", 1)
        bench.run(3)
        return seen


@pytest.mark.parametrize(("control", "is_right"), [(0x26, True), (0x06, False), (0x36, False)])
def test_a_segment_with_parity_expects_it(control: int, is_right: bool) -> None:
    line = LINE | {
        "segments": {
            "bus0": {"format": "8E1", "stations": ["u1.main", "u2.main"], "taps": {"tap": {"port": "memory"}}}
        }
    }
    errors, _, byte, tapped = told(line, says(control), listens(0x26))
    assert (errors, byte, tapped) == (0 if is_right else UPE, SENT, bytes((SENT,)))
    assert damaged(line, says(control)) == [not is_right]
