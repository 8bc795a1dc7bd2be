"""Views of a monitor: nothing is lost in them, however the bytes come."""

import re

from hypothesis import given
from hypothesis import strategies as st

from hil.cli.monitor.shown_bytes import HexView, PlainView, TimedView

PIECES = st.lists(st.tuples(st.binary(min_size=1, max_size=40), st.integers(0, 10**12)), max_size=8)


@given(PIECES)
def test_bytes_are_shown_as_they_are(pieces: list[tuple[bytes, int]]) -> None:
    view = PlainView()
    assert b"".join(view.came(*each) for each in pieces) == b"".join(data for data, _ in pieces)


@given(PIECES)
def test_a_line_feed_alone_goes_to_the_left_edge_if_asked(pieces: list[tuple[bytes, int]]) -> None:
    view, data = PlainView(is_raw=True, feeds_return=True), b"".join(data for data, _ in pieces)
    assert b"".join(view.came(*each) for each in pieces) == re.sub(rb"(?<!\r)\n", b"\r\n", data)


@given(PIECES)
def test_each_line_has_the_time_of_its_first_byte(pieces: list[tuple[bytes, int]]) -> None:
    view, wanted, is_begin = TimedView(), b"", True
    for data, at_ns in pieces:
        for byte in data:
            wanted += (f"{at_ns * 1e-9:12.6f} ".encode() if is_begin else b"") + bytes((byte,))
            is_begin = byte == 0x0A
    assert b"".join(view.came(*each) for each in pieces) == wanted


@given(PIECES, st.integers(20, 200), st.booleans())
def test_rows_of_hex_have_all_bytes_and_fit(
    pieces: list[tuple[bytes, int]], columns: int, has_time: bool
) -> None:
    view = HexView(columns=columns, has_time=has_time)
    shown = b"".join(view.came(*each) for each in pieces) + view.pause()
    rows, data = shown.decode().splitlines(), b""
    for row in rows:
        words = row[13:] if has_time else row
        number, digits = re.match(r"([0-9a-f]{8})  ((?:[0-9a-f]{2} )+)", words).groups()  # type: ignore[union-attr]
        assert int(number, 16) == len(data)
        data += bytes.fromhex(digits)
        assert len(row) < max(columns, 41)
    assert data == b"".join(data for data, _ in pieces)


def test_rows_of_hex_end_after_a_pause() -> None:
    view = HexView(is_raw=True)
    assert view.came(b"p\r\n") == b""
    assert view.is_holding()
    shown = view.pause()
    assert shown == b"00000000  70 0d 0a " + b" " * 39 + b" p..\r\n"
    assert not view.is_holding()
    assert view.pause() == b""


def test_what_is_typed_stands_in_a_line_without_a_time() -> None:
    view = TimedView(is_raw=True)
    assert view.echo(b"p") == b"p"
    assert view.came(b"ok\n", 1_500_000_000) == b"\r\n    1.500000 ok\r\n"
    assert view.echo(b"p\r") == b"p\r\n"
    assert view.came(b"ok", 2_000_000_000) == b"    2.000000 ok"
    assert view.fresh_line() == b"\r\n"
    assert view.fresh_line() == b""
