"""A processor that is the master of an SPI: another one is the slave, or an encoder on a motor's shaft."""

import pytest
from avr_words import DDRB, PORTB, SPCR, SPDR, SPIF, SPSR, cbi, in_, ldi, out, program, rjmp, sbi, sbrs, sts
from test_processor import axis_of, started

from hil.testing import Bench

KEPT = 0x100
"""Address of the bytes that came."""
SS = 2
"""Bit of port B: D10."""


def exchanged(byte: int, at: int) -> list[tuple[int, ...]]:
    wait = [in_(18, SPSR), sbrs(18, SPIF), rjmp(-3)]
    return [ldi(17, byte), out(SPDR, 17), *wait, in_(19, SPDR), sts(at, 19)]


def master(control: int, is_doubled: bool, frames: list[bytes]) -> bytes:
    """Program that sends frames in mode 1, and keeps what comes. ``control``: SPR1 and SPR0."""
    set_up = [ldi(16, 0x2C), sbi(PORTB, SS), out(DDRB, 16), ldi(16, 0x54 | control), out(SPCR, 16)]
    set_up += [ldi(16, int(is_doubled)), out(SPSR, 16)]
    at = KEPT
    for frame in frames:
        set_up.append(cbi(PORTB, SS))
        for byte in frame:
            set_up += exchanged(byte, at)
            at += 1
        set_up.append(sbi(PORTB, SS))
    return program(*set_up, rjmp(-1))


def test_another_processor_is_the_slave() -> None:
    slave = program(
        *(ldi(16, 1 << 4), out(DDRB, 16), ldi(16, 0x44), out(SPCR, 16)),
        *(*exchanged(0xA5, KEPT), rjmp(-1)),
    )
    wires = [{"from": f"u1.D{pin}", "to": f"u2.D{pin}"} for pin in (10, 11, 13)]
    devices = {"u1": {"profile": "uno"}, "u2": {"profile": "uno"}}
    with Bench(
        {"bench": "b", "devices": devices, "wires": [*wires, {"from": "u2.D12", "to": "u1.D12"}]}
    ) as b:
        listens = started(b, slave, "u2")
        sends = started(b, master(1, False, [b"\x3c"]))
        b.run(0.1)
        assert (sends.data(KEPT, 1), listens.data(KEPT, 1)) == (b"\xa5", b"\x3c")


WIRES = [
    *({"from": "u1.D10", "to": "e1.CSn"}, {"from": "u1.D11", "to": "e1.MOSI"}),
    *({"from": "e1.MISO", "to": "u1.D12"}, {"from": "u1.D13", "to": "e1.CLK"}),
]


@pytest.mark.parametrize(("control", "is_doubled"), [(0, True), (0, False), (1, False), (3, False)])
def test_an_encoder_is_read_at_every_speed(control: int, is_doubled: bool) -> None:
    devices = {
        "u1": {"profile": "uno"},
        "d1": {"profile": "easydriver"},
        "e1": {"profile": "as5047d", "magnet": {"of": "d1", "zero_deg": -123.0}},
    }
    with Bench({"bench": "b", "devices": devices, "wires": WIRES}) as bench:
        frames = [b"\xff\xff", b"\xc0\x00", b"\xc0\x00"]
        processor = started(bench, master(control, is_doubled, frames))
        bench.run(1)
        answers = processor.data(KEPT, 6)
        angle = int.from_bytes(answers[2:4], "big")
        assert (angle & 0x3FFF) * 360 / 16384 == pytest.approx(
            123 + axis_of(bench, "d1").get("position_deg"), abs=0.05
        )
        assert (angle.bit_count() % 2, angle & 0x4000) == (0, 0)
        assert answers[4:6] == bytes(2)
        assert bench.axis("e1").snapshot().spi_frames == 3


def test_two_encoders_share_a_line_that_each_leaves_open() -> None:
    devices = {
        "u1": {"profile": "uno"},
        "d1": {"profile": "easydriver"},
        "e1": {"profile": "as5047d", "magnet": {"of": "d1", "zero_deg": -123.0}},
        "e2": {"profile": "as5047d", "magnet": "d1"},
    }
    shared = [
        {"from": wire["from"].replace("e1", "e2"), "to": wire["to"].replace("e1", "e2")} for wire in WIRES[1:]
    ]
    with Bench({"bench": "b", "devices": devices, "wires": [*WIRES, *shared]}) as bench:
        processor = started(bench, master(0, False, [b"\xff\xff"] * 2))
        bench.run(1)
        angle = int.from_bytes(processor.data(KEPT + 2, 2), "big") & 0x3FFF
        assert angle == bench.axis("e1").snapshot().raw
        assert bench.axis("e2").snapshot().spi_frames == 0
        pin = processor.pin("D12")
        assert (pin.is_output, pin.level) == (False, 0)  # nothing drives it


def test_processors_of_a_line_each_have_an_encoder() -> None:
    """They go on together in steps of some microseconds; what each reads is of its own time."""
    devices = {"d1": {"profile": "easydriver"}}
    for number, zero_deg in ((1, -123.0), (2, 10.0)):
        devices[f"u{number}"] = {"profile": "uno"}
        devices[f"e{number}"] = {"profile": "as5047d", "magnet": {"of": "d1", "zero_deg": zero_deg}}
    wires = [
        {end: pin.replace("1.", f"{number}.") for end, pin in wire.items()}
        for number in (1, 2)
        for wire in WIRES
    ]
    with Bench({"bench": "b", "devices": devices, "wires": wires}) as bench:
        flash = master(0, True, [b"\xff\xff"] * 3)
        processors = [started(bench, flash, name) for name in ("u1", "u2")]
        bench.run(1)
        for number, processor in enumerate(processors, 1):
            angle = int.from_bytes(processor.data(KEPT + 4, 2), "big") & 0x3FFF
            assert angle == bench.axis(f"e{number}").snapshot().raw
