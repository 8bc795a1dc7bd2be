"""Numbers typed after ``r``: their forms, and when the board stops waiting for more of one."""

import struct

import pytest

from hil.testing import Bench

CONFIG = {"bench": "forms", "devices": {"m1": {"profile": "mechaduino", "port": "memory"}}}

FORMS = [
    # Typed 300 ms after r and all at once; how long the answer takes, the set-point's bits, the answer.
    # Source: output of the public firmware 0.1.5 and of Stream::parseFloat (Arduino SAMD core 1.6.20).
    ("90", 1000, "42b40000", "90.00"),
    ("90\n", 0, "42b40000", "90.00"),
    ("90.5\r\n", 0, "42b50000", "90.50"),
    ("-12.25\n", 0, "c1440000", "-12.25"),
    (".5\n", 0, "3f000000", "0.50"),
    ("abc5\n", 0, "40a00000", "5.00"),
    ("--3\n", 0, "00000000", "0.00"),
    ("-", 1000, "00000000", "0.00"),
    ("\n", 1000, "00000000", "0.00"),
    ("1.2.3\n", 0, "3f99999a", "1.20"),
    ("+7\n", 0, "40e00000", "7.00"),
    ("0x10\n", 0, "00000000", "0.00"),
    ("1,000\n", 0, "3f800000", "1.00"),
    ("99999999999\n", 0, "4e90edd0", "1215752192.00"),
    ("2147483648\n", 0, "cf000000", "-2147483648.00"),
    ("4294967296\n", 0, "00000000", "0.00"),
    ("3.14159265\n", 0, "40490fd9", "3.14"),
    ("3.1415926535\n", 0, "3e0a5bba", "0.14"),
    ("12 34\n", 0, "41400000", "12.00"),
    ("-.5\n", 0, "bf000000", "-0.50"),
    ("-0.0\n", 0, "00000000", "0.00"),
    ("1234567.891\n", 0, "4996b43f", "1234567.87"),
    ("97.65\n", 0, "42c34ccd", "97.65"),
    ("0000123.4500\n", 0, "42f6e665", "123.45"),
    ("16777217\n", 0, "4b800000", "16777216.00"),
    ("nan\n", 1000, "00000000", "0.00"),
    ("-\n5\n", 0, "00000000", "0.00"),
    ("..5", 0, "00000000", "0.00"),
    ("\r\n\r\n42\n", 0, "42280000", "42.00"),
    ("90\x00", 0, "42b40000", "90.00"),
]


@pytest.mark.parametrize("bytewise", [False, True], ids=["whole", "bytewise"])
@pytest.mark.parametrize(("typed", "wait_ms", "bits", "answer"), FORMS)
def test_a_number(typed: str, wait_ms: int, bits: str, answer: str, bytewise: bool) -> None:
    bench = Bench(CONFIG)
    bench.run_until(5000)
    port = bench.port("m1")
    port.read()
    port.write(b"r")
    bench.run(300)
    data = typed.encode("latin-1")
    for piece in [data[i : i + 1] for i in range(len(data))] if bytewise else [data]:
        port.write(piece)
    bench.run(2000)
    assert port.read_timed() == [
        (5000_000_000, b"Enter setpoint:\r\n"),
        ((5300 + wait_ms) * 1_000_000, answer.encode() + b"\r\n"),
    ]
    assert struct.pack(">f", bench.axis("m1").snapshot().r).hex() == bits


@pytest.mark.parametrize("gap_ms", [1, 500, 999, 999.999999])
def test_every_byte_has_its_own_second(gap_ms: float) -> None:
    bench = Bench(CONFIG)
    bench.run_until(5000)
    port = bench.port("m1")
    port.write(b"r")
    for byte in b"-12.5":
        port.write(bytes([byte]))
        bench.run(gap_ms)
    port.read()
    port.write(b"\n")
    assert port.read() == b"-12.50\r\n"


def test_a_byte_one_second_after_the_last_is_too_late() -> None:
    bench = Bench(CONFIG)
    bench.run_until(5000)
    port = bench.port("m1")
    port.write(b"r-12.")
    bench.run(1000)
    port.read()
    port.write(b"5\n")
    assert bench.axis("m1").snapshot().r == -12.0
    assert port.read() == b""
    bench.run(100)
    assert port.read() == b""
