"""Lines of a bench's log, from lines of its recording."""

import gzip
import json
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.recorded.said_lines import SILENCE_NS, SaidLine, SaidLines, line_of
from hil.recorded.said_reading import SaidReading, SaidWish
from hil.sim.noted_events import NotedEvent, encode_event

HEADER = json.dumps({"format": "hil-inputs", "config": {"devices": {"m1": {}}, "segments": {"bus0": {}}}})


def sent(at_ns: int, device: str, data: bytes, port: str = "") -> bytes:
    more = {"port": port} if port else {}
    row = {"at_ns": at_ns, "device": device, "sent": data.hex(), "state": None} | more
    return json.dumps(row, separators=(",", ":")).encode() + b"\n"


def event(
    kind: str, text: str, *, of: str = "", who: str = "bench", count: int = 1, number: int = 1
) -> bytes:
    return encode_event(NotedEvent(number, kind, 7, 7, of, who, text, count)).encode() + b"\n"


def read(*lines: bytes) -> list[SaidLine]:
    said = SaidLines()
    found = [each for line in (HEADER.encode() + b"\n", *lines) for each in said.add(line)]
    return [*found, *said.silent()]


def texts(*lines: bytes) -> list[tuple[int, str, str]]:
    return [(each.at_ns, each.source, each.text) for each in read(*lines)]


def test_pieces_of_a_board_become_lines() -> None:
    pieces = sent(1, "m1", b"\r\nHel"), sent(2, "m1", b"lo\r\n\r\nread"), sent(3, "m1", b"y")
    assert texts(*pieces) == [(1, "m1", "Hello"), (2, "m1", "ready")]


def test_a_prompt_is_a_line_after_silence() -> None:
    check = json.dumps({"at_ns": SILENCE_NS + 1, "check": 1, "lines": 2}).encode() + b"\n"
    said = SaidLines()
    lines = (HEADER.encode(), sent(1, "m1", b"> "), check)
    assert [each.text for line in lines for each in said.add(line)] == ["> "]


def test_ports_are_apart_and_bytes_that_are_no_text_are_escaped() -> None:
    found = read(sent(1, "s1", b"ok "), sent(2, "s1", b"\x05\x00\x1b\n", "network"), sent(3, "s1", b"so\n"))
    assert {(each.source, each.kind, each.text) for each in found} == {
        ("s1", "text", "ok so"),
        ("s1.network", "bytes", r"\x05\x00\x1b\n"),
    }


def test_packets_are_lines_of_their_own() -> None:
    found = texts(*(sent(at_ms * 10**6, "s1", b"\x05\x01", "network") for at_ms in (1, 2, 9)))
    assert [each[0] for each in found] == [1_000_000, 9_000_000]


@given(st.binary(max_size=1500), st.lists(st.integers(0, 1500), max_size=8))
def test_however_it_is_cut_all_is_shown_once_and_harmless(data: bytes, cuts: list[int]) -> None:
    places = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    pieces = [data[a:b] for a, b in pairwise(places)]
    found = read(*(sent(number, "m1", piece) for number, piece in enumerate(pieces)))
    assert all(each.text.isprintable() and len(each.text) <= 800 for each in found)
    plain = "".join(each.text for each in found)
    wanted = bytes(byte for byte in data if 0x21 <= byte <= 0x7E and byte != 0x5C)
    assert bytes(byte for byte in wanted) == b"" or all(chr(byte) in plain for byte in set(wanted))


@pytest.mark.parametrize(
    ("kind", "text", "level", "shown"),
    [
        ("log", "WARNING disk is full", "warning", "disk is full"),
        ("log", "INFO reloaded", "info", "reloaded"),
        ("log", "CRITICAL the bench ends", "error", "the bench ends"),
        ("motors", "it stalled", "warning", "it stalled"),
        ("faults", "wire_cut", "warning", "fault wire_cut"),
        ("trouble", "no power", "error", "no power"),
        ("trouble", "over: no power", "info", "over: no power"),
        ("runs", "square done", "info", "run square done"),
    ],
)
def test_levels_of_events(kind: str, text: str, level: str, shown: str) -> None:
    (line,) = read(event(kind, text, of="m1"))
    assert (line.level, line.text, line.source) == (level, shown, "m1")


def test_who_asked_and_how_often() -> None:
    (line,) = read(event("refusals", "no", who="web ann", count=3))
    assert (line.source, line.text) == ("bench", "refused: no (3 times) (by web ann)")


@given(st.binary(max_size=200))
def test_a_damaged_line_says_nothing(line: bytes) -> None:
    read(line + b"\n")


def test_a_line_is_of_a_device_and_its_parts() -> None:
    line = line_of(NotedEvent(1, "runs", 0, 0, "m1, arm.elbow", "bench", "x", 1))
    assert [line.is_of(name) for name in ("m1", "arm", "arm.elbow", "arm.el", "m")] == [
        *(True, True, True),
        *(False, False),
    ]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "run.hil.gz"
    lines = [HEADER.encode() + b"\n"]
    lines += [sent(at * 10**9, "m1", b"line %d\n" % at) for at in range(20)]
    lines += [
        event("motors", "it stalled", of="m1", number=4),
        event("motors", "it stalled", of="m1", number=4, count=5),
    ]
    path.write_bytes(gzip.compress(b"".join(lines)))
    return path


def test_the_latest_lines_in_the_order_of_time(recording: Path) -> None:
    def latest(**wish: Any) -> list[str]:
        with closing(SaidReading(recording)) as reading:
            return [each.text for each in reading.latest(SaidWish(**wish), goes_on=False)]

    assert latest(most=2) == ["line 18", "line 19"]
    assert latest()[:2] == ["line 0", "it stalled (5 times)"]
    assert latest(level="warning") == ["it stalled (5 times)"]
    assert latest(device="s1") == []


def test_a_recording_that_grows_is_read_on(recording: Path) -> None:
    plain = recording.with_name("run.log")
    plain.write_bytes(gzip.decompress(recording.read_bytes()))
    with closing(SaidReading(plain)) as reading, plain.open("ab") as file:
        assert len(reading.latest(SaidWish(), goes_on=True)) == 21
        file.write(sent(30 * 10**9, "m1", b"more\nand")[:40])
        file.flush()
        assert list(reading.more()) == []
        file.write(sent(30 * 10**9, "m1", b"more\nand")[40:])
        file.write(b'{"end":true,"why":"stopped"}\n')
        file.flush()
        assert [each.text for each in reading.more()] == ["more"]
        assert reading.said.end == "stopped"
