"""Logs of CAN as python-can's readers and tshark read them, and captures as text."""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.candump_log import LoggedFrame
from bridges.can.frames.socketcan import pack_error, pack_frame
from hil.cli.captures.capture_files import blocks_of, capture_file, records_of
from hil.cli.captures.capture_input import any_form, of_file
from hil.cli.captures.time_order import in_window
from hil.compose.decoded_item import DecodedItem, as_lines
from hil.compose.decoding import Decoder, decoded, decoded_live, decoded_log
from hil.discovery.named_kinds import find_logs
from hil.wire.pcapng import (
    LINKTYPE_CAN_SOCKETCAN,
    CaptureError,
    Interface,
    Record,
    RecordKind,
    cut_off,
    frame_record,
    header,
    read,
    record,
    whole_blocks,
)

BUSES = [
    Interface("can0", baud=1_000_000, link=LINKTYPE_CAN_SOCKETCAN),
    Interface("can1", baud=500_000, link=LINKTYPE_CAN_SOCKETCAN),
]
SINCE_NS = 1_700_000_000_000_000_000
FRAMES = [
    CanFrame(0, b"\1\5"),
    CanFrame(0x705, b"\0"),
    CanFrame(0x605, bytes.fromhex("4041600000000000")),
    CanFrame(0x585, bytes.fromhex("4B41600037020000")),
    CanFrame(0x1ABCDEF0, bytes(range(8)), True),
    CanFrame(0x705, b"", False, True, 1),
    CanFrame(0x80),
]
CAPTURE = (
    header("hil test", BUSES)
    + b"".join(
        frame_record(at & 1, SINCE_NS + 1000 * at, pack_frame(frame), "m1.canopen")
        for at, frame in enumerate(FRAMES)
    )
    + frame_record(0, SINCE_NS + 10**9, pack_error("stuff"))
)
ENDINGS = (".log", ".asc", ".blf")


class Connection:
    """Connection that gives bytes in pieces."""

    def __init__(self, data: bytes, size: int) -> None:
        self._rest, self._size = data, size

    def recv(self, most: int) -> bytes:
        piece, self._rest = self._rest[: self._size], self._rest[self._size :]
        return piece


def words(capture: bytes | Iterator[Record | None]) -> Iterator[str]:
    if isinstance(capture, bytes):
        return as_lines(decoded(read(capture), Decoder()))
    return as_lines(in_window(decoded_live(capture, Decoder())))


def written(folder: Path, ending: str, capture: bytes = CAPTURE) -> Path:
    path = folder / f"out{ending}"
    file = capture_file(str(path), 0, 1)
    try:
        for blocks in blocks_of(Connection(capture, 100).recv):
            file.write(blocks)
    finally:
        file.close()
    return path


@pytest.mark.parametrize("ending", ENDINGS)
def test_python_can_reads_what_is_written(ending: str, tmp_path: Path) -> None:
    with can.LogReader(written(tmp_path, ending)) as reader:
        messages = list(reader)
    assert len(messages) == len(FRAMES) + 1
    for at, (frame, message) in enumerate(zip(FRAMES, messages, strict=False)):
        assert message.arbitration_id == frame.id
        assert message.is_extended_id == frame.is_extended
        assert message.is_remote_frame == frame.is_remote
        assert message.dlc == frame.dlc
        assert bytes(message.data or b"") == frame.data
        assert message.channel == (f"can{at & 1}" if ending == ".log" else at & 1)
        assert message.timestamp - messages[0].timestamp == pytest.approx(at * 1e-6, abs=1e-6)
    assert messages[-1].is_error_frame
    assert messages[-1].timestamp - messages[0].timestamp == pytest.approx(1, abs=1e-6)
    if ending != ".asc":  # which has milliseconds of the day, in local time
        assert messages[0].timestamp == pytest.approx(SINCE_NS / 1e9, abs=1e-3)


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_log_is_read_back(ending: str, tmp_path: Path) -> None:
    path = written(tmp_path, ending)
    items = list(of_file(path.name, path.read_bytes(), Decoder()))
    assert [(item.can_id, item.data) for item in items[:-1]] == [(each.id, each.data) for each in FRAMES]
    assert [item.source for item in items[:2]] == ["can0", "can1"]
    text = list(as_lines(items))
    assert text[5] == "    0.000005 can1 705#R1               guarding of 5: what is your state"
    assert text[3] == "    0.000003 can1 585#4B41600037020000 SDO from 5: 6041h Statusword is 0237h"
    # Vector's logs have no class of an error.
    assert text[-1] == f"    1.000000 can0 {'stuff ' if ending == '.log' else ''}error"


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_damaged_in_a_log_is_said(ending: str, tmp_path: Path) -> None:
    data = written(tmp_path, ending).read_bytes()
    for cut in (b"\0\1\2" * 50, data[: len(data) * 3 // 4] + b"\xff\xfe~~" * 9):
        items, decoder, said = list[DecodedItem](), Decoder(), ""
        try:
            items.extend(of_file(f"x{ending}", cut, decoder))
        except CaptureError as error:
            said = str(error)
        assert (said or decoder.left_out.told()).isprintable()
        assert said or decoder.left_out.total
        assert len(items) <= len(FRAMES) + 1


def test_a_log_is_known_by_what_it_has_whatever_its_name(tmp_path: Path) -> None:
    for ending in (*ENDINGS, ".pcapng"):
        data = written(tmp_path, ending).read_bytes()
        assert len(list(of_file("x.txt", data, Decoder()))) == len(FRAMES) + 1
    with pytest.raises(CaptureError, match=r"no capture .* and no log of CAN"):
        of_file("x.txt", b"x" * 90, Decoder())


def test_a_binary_log_that_is_cut_off_is_said(tmp_path: Path) -> None:
    data = written(tmp_path, ".blf").read_bytes()
    for size in (len(data) - 1, len(data) - 40, 160):
        with pytest.raises(CaptureError, match=r"cut off|cannot read it"):
            list(of_file("x.blf", data[:size], Decoder()))


def test_what_is_no_can_has_no_place_in_a_log(tmp_path: Path) -> None:
    capture = header("x", [Interface("bus0", "sac")]) + record(0, 5, RecordKind.RX, b"x")
    with pytest.raises(CaptureError, match="bus0 is no CAN bus; name the file"):
        written(tmp_path, ".log", capture)


def test_an_empty_log_is_one(tmp_path: Path) -> None:
    for ending in ENDINGS:
        with can.LogReader(written(tmp_path, ending, header("x", BUSES))) as reader:
            assert list(reader) == []


def test_a_capture_in_words_and_its_faults() -> None:
    assert list(words(CAPTURE))[:4] == [
        "    0.000000 can0 000#0105             NMT to node 5: start (m1.canopen)",
        "    0.000001 can1 705#00               boot-up of 5 (m1.canopen)",
        "    0.000002 can0 605#4041600000000000 SDO to 5: read 6041h Statusword (m1.canopen)",
        "    0.000003 can1 585#4B41600037020000 SDO from 5: 6041h Statusword is 0237h (m1.canopen)",
    ]
    broken, decoder = CAPTURE + frame_record(0, SINCE_NS, b"\0\0\0") + CAPTURE, Decoder()
    assert len(list(decoded(read(broken), decoder))) == 2 * (len(FRAMES) + 1)
    said = f"1 left out: byte {len(CAPTURE)}: 3 bytes are no CAN frame, which has 8 and more"
    assert decoder.left_out.told() == said


@pytest.mark.skipif(not shutil.which("tshark"), reason="needs tshark")
def test_tshark_shows_frames_errors_and_canopen(tmp_path: Path) -> None:
    path = written(tmp_path, ".pcapng")
    fields = [
        "frame.interface_name",
        "can.id",
        "can.flags.xtd",
        "can.flags.rtr",
        "can.flags.err",
        "_ws.col.Info",
    ]
    command = ["tshark", "-r", path, "-d", "can.subdissector,canopen", "-T", "fields"]
    shown = subprocess.run(
        [*command, *(word for field in fields for word in ("-e", field))],
        capture_output=True,
        text=True,
        check=True,
    )
    rows = [line.split("\t") for line in shown.stdout.splitlines()]
    assert len(rows) == len(FRAMES) + 1
    for at, (row, frame) in enumerate(zip(rows, FRAMES, strict=False)):
        assert row[0] == f"can{at & 1}"
        assert int(row[1]) == frame.id
        assert row[2:4] == [str(int(frame.is_extended)), str(int(frame.is_remote))]
    assert [row[5] for row in rows[:4]] == [
        "NMT: Start remote node [0x5]",
        "NMT Error Control: Boot-up [0x5]",
        "Default-SDO (rx): Initiate upload request",
        "Default-SDO (tx): Initiate upload response",
    ]
    assert rows[-1][4:] == ["1", "ERR: Protocol violation, Bus error"]
    damaged = subprocess.run(
        [*command[:5], "-Y", "_ws.malformed"], capture_output=True, text=True, check=True
    )
    assert damaged.stdout == ""


def test_a_capture_that_comes_in_pieces_is_decoded_as_it_comes() -> None:
    for size in (1, 7, 10_000):
        assert list(words(records_of(Connection(CAPTURE, size).recv))) == list(words(CAPTURE))
    for cut in (CAPTURE[:-3], CAPTURE[: len(CAPTURE) - 90]):
        texts = []
        for source in (cut, records_of(Connection(cut, 50).recv)):
            with pytest.raises(CaptureError) as caught:
                list(words(source))
            texts.append(str(caught.value))
        assert texts[0] == texts[1] == cut_off(whole_blocks(cut))
    with pytest.raises(CaptureError, match="this is no pcapng"):
        list(words(records_of(Connection(b"abcdefgh", 1).recv)))


def test_times_of_a_log_are_those_of_the_capture() -> None:
    rows = [LoggedFrame(at_ns, "can0", CanFrame(1)) for at_ns in (10**18, 10**18 + 1_234_567)]
    assert [line[:13] for line in as_lines(decoded_log(find_logs()[0], rows, Decoder()))] == [
        "    0.000000 ",
        "    0.001235 ",
    ]


def test_a_pipe_may_have_any_form(tmp_path: Path) -> None:
    for ending in ENDINGS:
        path = written(tmp_path, ending)
        piped = any_form(Connection(path.read_bytes(), 3).recv, Decoder())
        assert list(as_lines(piped)) == list(as_lines(of_file(path.name, path.read_bytes(), Decoder())))
    assert list(as_lines(any_form(Connection(CAPTURE, 2).recv, Decoder()))) == list(words(CAPTURE))
    for strange, said in ((b"", "nothing in it"), (b"no capture", "no log of CAN")):
        with pytest.raises(CaptureError, match=said):
            any_form(Connection(strange, 3).recv, Decoder())


def test_candump_in_a_pipe_is_decoded_line_by_line() -> None:
    pieces = iter([b"(1.0) can0 705#00\n(1.5) can", None, b"0 000#0105", b""])
    items = any_form(lambda size: next(pieces), Decoder())
    assert next(items).say() == "705#00               boot-up of 5"
    assert next(pieces) is None, "the first frame waits for the second"
    assert next(items).say() == "000#0105             NMT to node 5: start"


def test_files_say_where_they_are(tmp_path: Path) -> None:
    path = tmp_path / "a.pcapng"
    for files, said in ((9, f"{tmp_path}/a.pcapng to {tmp_path}/a-9.pcapng"), (1, f"in {tmp_path}/a-")):
        file = capture_file(str(path), 300, files)
        for blocks in blocks_of(Connection(CAPTURE, 60).recv):
            file.write(blocks)
        file.close()
        assert said.removesuffix("a-9.pcapng") in file.told()
    whole = capture_file(str(path), 0, 1)
    whole.write(CAPTURE)
    whole.close()
    assert whole.told() == f"{len(CAPTURE)} bytes in {path}"
