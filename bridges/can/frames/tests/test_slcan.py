"""Lawicel's protocol: dialogues, any bytes in any pieces, and python-can's own client at the other end."""

import os
import random
import threading
import tty
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from bridges.can.frames.can_frame import CanFrame, check
from bridges.can.frames.slcan import (
    BIT_RATES,
    LINE_MAX,
    SlcanAdapter,
    SlcanCommand,
    SlcanSplitter,
    SlcanStatus,
    accepts,
    bit_rate_of,
    encode,
    parse,
)
from hil.testing import check_codec

DIALOGUES = yaml.safe_load((Path(__file__).parent / "slcan_dialogue.yaml").read_text())
AT_NS = 61_234_999_999


class Channel:
    """What an adapter does with its bus."""

    def __init__(self) -> None:
        self.sent: list[CanFrame] = []
        self.opened: list[tuple[int, bool]] = []
        self.closed = 0
        self.is_full = False

    def open(self, bit_rate: int, *, is_listening: bool) -> bool:
        self.opened.append((bit_rate, is_listening))
        return True

    def close(self) -> None:
        self.closed += 1

    def send(self, frame: CanFrame) -> bool:
        check(frame)
        self.sent.append(frame)
        return not self.is_full

    def status(self) -> SlcanStatus:
        return SlcanStatus.ERROR_WARNING


@pytest.mark.parametrize("dialogue", DIALOGUES, ids=lambda dialogue: dialogue["name"])
def test_dialogues(dialogue: dict[str, Any]) -> None:
    adapter = SlcanAdapter(Channel())
    for line in dialogue["lines"]:
        if isinstance(line, dict):
            frame = parse(line["bus"].encode()).frame
            assert frame
            assert adapter.received(frame, AT_NS) == line["gets"].encode(), line
        else:
            typed, wanted = line
            assert adapter.feed(typed.encode() + b"\r") == wanted.encode(), line


def test_rates_and_modes_arrive() -> None:
    channel = Channel()
    adapter = SlcanAdapter(channel)
    for number in range(9):
        adapter.feed(b"S%d\rO\rC\r" % number)
    adapter.feed(b"s031C\rL\r")
    adapter.close()
    adapter.close()
    assert channel.opened == [*((rate, False) for rate in BIT_RATES), (125_000, True)]
    assert channel.closed == 10


@pytest.mark.parametrize(("registers", "rate"), [("031C", 125_000), ("0014", 1_000_000), ("011C", 250_000)])
def test_registers_are_a_rate(registers: str, rate: int) -> None:
    assert bit_rate_of(bytes.fromhex(registers)) == rate


def test_a_frame_that_finds_no_mailbox_is_refused() -> None:
    channel = Channel()
    channel.is_full = True
    assert SlcanAdapter(channel).feed(b"S8\rO\rt1230\r") == b"\r\r\a"


def test_the_first_byte_counts_for_the_first_filter() -> None:
    code, mask = bytes.fromhex("200A1005"), bytes.fromhex("00100010")
    assert accepts(code, mask, CanFrame(0x100, b"\xa5"))
    assert accepts(code, mask, CanFrame(0x100, is_remote=True))
    assert not accepts(code, mask, CanFrame(0x100, b"\xa4"))
    assert accepts(code, mask, CanFrame(0x080, b"\xa4"))


def reader() -> Any:
    splitter = SlcanSplitter()
    return lambda data, at_ns: splitter.feed(data)


def test_it_keeps_to_what_codecs_keep_to() -> None:
    frame = CanFrame(0x1FFFFFFF, bytes(range(8)), is_extended=True)
    line = b"T1FFFFFFF80001020304050607\r"
    messages: dict[bytes, Sequence[object]] = {
        line: [SlcanCommand("T", line[1:-1], frame)],
        b"r1234\r": [SlcanCommand("r", b"1234", CanFrame(0x123, b"", False, True, 4))],
        b"S8\r": [SlcanCommand("S", b"8")],
        b"\r": [SlcanCommand("\r")],
        b"nonsense\r": [SlcanCommand("")],
    }
    check_codec(reader, messages)


def test_what_is_encoded_is_parsed() -> None:
    chance = random.Random(2)
    for _ in range(2000):
        frame = some_frame(chance)
        line = encode(frame)
        assert parse(line[:-1]).frame == frame
        assert len(line) <= LINE_MAX + 1
        stamped = encode(frame, chance.randrange(10**15))
        assert stamped[:-5] == line[:-1]
        assert int(stamped[-5:-1], 16) < 60_000


def some_frame(chance: random.Random) -> CanFrame:
    is_extended, size = chance.random() < 0.5, chance.randrange(9)
    number = chance.randrange(1 << 29 if is_extended else 1 << 11)
    if chance.random() < 0.2:
        return CanFrame(number, b"", is_extended, True, size)
    return CanFrame(number, chance.randbytes(size), is_extended)


@pytest.mark.long
def test_fuzz_any_bytes_get_their_answer() -> None:
    """Lines with some bytes changed, in any pieces: ``HIL_FUZZ`` of them. Each gets one answer; what is sent
    could be sent; the frame behind is understood; and pieces change nothing."""
    chance = random.Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    whole, cut, count = Channel(), Channel(), 0
    one, other = SlcanAdapter(whole), SlcanAdapter(cut)
    for adapter in (one, other):
        adapter.feed(b"S8\rO\r")
    others = (b"V", b"N", b"F", b"C", b"O", b"L", b"S8", b"s031C", b"Z1", b"M00000000", b"mFFFFFFFF", b"")
    for _ in range(int(os.environ.get("HIL_FUZZ", "100000"))):
        line = bytearray(chance.choice(others) if chance.random() < 0.2 else encode(some_frame(chance))[:-1])
        for _ in range(chance.randrange(4)):
            at = chance.randrange(len(line) + 1)
            line[at : at + chance.randrange(3)] = chance.randbytes(chance.randrange(3))
        if chance.random() < 0.001:
            line += chance.randbytes(200)
        data = bytes(line) + b"\r"
        answer = one.feed(data)
        at = chance.randrange(len(data))
        assert other.feed(data[:at]) + other.feed(data[at:]) == answer
        assert answer.count(b"\r") + answer.count(b"\a") == data.count(b"\r")
        assert cut.sent == whole.sent
        count += len(whole.sent)
        whole.sent.clear()
        cut.sent.clear()
    assert count > 0
    one.feed(b"\rC\rS8\rO\r")
    assert one.feed(b"t1230\r") == b"z\r"


# ---- python-can's client ----


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    main, side = os.openpty()
    tty.setraw(side)
    yield main, os.ttyname(side)
    for each in (main, side):
        os.close(each)


def serve(adapter: SlcanAdapter, main: int, is_over: threading.Event) -> None:
    while not is_over.is_set():
        try:
            data = os.read(main, 4096)
        except OSError:
            return
        if answer := adapter.feed(data):
            os.write(main, answer)


def test_python_cans_client_and_ours_understand_each_other(terminal: tuple[int, str]) -> None:
    can = pytest.importorskip("can")
    main, name = terminal
    channel = Channel()
    adapter = SlcanAdapter(channel)
    is_over = threading.Event()
    thread = threading.Thread(target=serve, args=(adapter, main, is_over), daemon=True)
    thread.start()
    chance = random.Random(3)
    frames = [some_frame(chance) for _ in range(500)]
    with can.Bus(interface="slcan", channel=name, bitrate=500_000, sleep_after_open=0) as client:
        assert client.get_version(5) == (10, 13)
        assert client.get_serial_number(5) == "H001"
        assert channel.opened[-1] == (500_000, False)
        for frame in frames:
            client.send(message(can, frame))
        assert client.get_serial_number(5) == "H001"  # all before it has been read
        assert channel.sent == frames
        for at in range(0, len(frames), 50):
            part = frames[at : at + 50]
            os.write(main, b"".join(adapter.received(frame, 0) for frame in part))
            got = [client.recv(5) for _ in part]
            assert [value(each) for each in got] == part
        is_over.set()
    thread.join(5)
    assert not thread.is_alive()
    assert channel.closed > 0


def message(can: Any, frame: CanFrame) -> Any:
    return can.Message(
        arbitration_id=frame.id,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        dlc=frame.dlc,
        data=frame.data,
    )


def value(got: Any) -> CanFrame:
    return CanFrame(
        got.arbitration_id,
        bytes(got.data),
        got.is_extended_id,
        got.is_remote_frame,
        got.dlc if got.is_remote_frame else 0,
    )
