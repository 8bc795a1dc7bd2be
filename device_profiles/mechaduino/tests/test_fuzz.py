"""Any bytes: the board never fails, and does the same again."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.testing import Bench
from hil.vocab.time import SimTimeNs

DEVICE = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
CONFIG = {"bench": "fuzz", "devices": {"m1": DEVICE}}
QUICK = b"sdpexvtynrkmh0123456789.-\r\n q"
"""Letters that take a second at most, and what numbers are made of."""


def play(
    pieces: list[tuple[float, bytes]], baud: int | None = None
) -> tuple[list[tuple[SimTimeNs, bytes]], str]:
    bench = Bench(CONFIG if baud is None else {"bench": "fuzz", "devices": {"m1": DEVICE | {"baud": baud}}})
    bench.run(4000)
    for gap_ms, data in pieces:
        bench.port("m1").write(data)
        bench.run(gap_ms)
    assert bench.device("m1").failed is None
    return bench.port("m1").read_timed(), repr(bench.axis("m1").snapshot().values)


PIECES = st.lists(
    st.tuples(
        st.floats(0, 1500),
        st.one_of(st.binary(max_size=30), st.lists(st.sampled_from(QUICK), max_size=30).map(bytes)),
    ),
    max_size=8,
)


@pytest.mark.long
@settings(max_examples=60)
@given(PIECES)
def test_any_bytes_do_no_harm_and_the_same_twice(pieces: list[tuple[float, bytes]]) -> None:
    assert play(pieces) == play(pieces)


@settings(max_examples=20)
@given(PIECES, st.sampled_from([300, 9600, 115200]))
def test_any_bytes_on_a_paced_line(pieces: list[tuple[float, bytes]], baud: int) -> None:
    assert play(pieces, baud) == play(pieces, baud)


def flood(size: int) -> list[bytes]:
    noise = random.Random(20180101)
    data = bytes(noise.randrange(256) for _ in range(size))
    pieces = []
    while data:
        length = noise.randrange(1, 4096)
        pieces.append(data[:length])
        data = data[length:]
    return pieces


@pytest.mark.thorough
@pytest.mark.long
def test_a_flood_of_200_kB_and_the_board_still_answers() -> None:
    # c, w, j, g and a would take hours of simulated time between them; they have their own test below.
    slow = str.maketrans("", "", "cwjga")
    pieces = [piece.decode("latin-1").translate(slow).encode("latin-1") for piece in flood(200_000)]
    ends = []
    for _ in range(2):
        bench = Bench(CONFIG)
        bench.run(4000)
        for piece in pieces:
            bench.port("m1").write(piece)
            bench.run(50)
        bench.run(600_000)
        assert bench.device("m1").failed is None
        # Out of whatever menu or number it is in, and a print.
        bench.port("m1").write(b"\nq\nq\nqq")
        bench.run(5000)
        bench.port("m1").read()
        bench.port("m1").write(b"p")
        bench.run(200)
        assert b", raw encoder: " in bench.port("m1").read()
        ends.append((hash(tuple(bench.port("m1").timeline)), repr(bench.axis("m1").snapshot().values)))
    assert ends[0] == ends[1]


def test_a_flood_while_the_slow_commands_run() -> None:
    for command in b"cwjga":
        bench = Bench(CONFIG)
        bench.run(4000)
        bench.port("m1").write(bytes([command]))
        bench.run(1000)
        for piece in flood(4000):
            bench.port("m1").write(piece)
            bench.run(10)
        assert bench.device("m1").failed is None
