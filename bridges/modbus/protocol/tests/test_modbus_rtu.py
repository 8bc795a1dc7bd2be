"""Modbus RTU on a line: frames by the silences between them, at every speed, however they come."""

import os
import random
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.frame import DATA_MAX, Frame, Malformed, crc16, encode
from bridges.modbus.protocol.rtu_framing import MODBUS_RTU
from bridges.modbus.protocol.splitter import RtuSplitter
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import character_ns, gap_ns, silence_ns

BAUDS = st.sampled_from([300, 1200, 9600, 19200, 19201, 38400, 115200, 1_000_000])
FRAMES = st.builds(encode, st.integers(0, 255), st.integers(0, 255), st.binary(max_size=DATA_MAX))
LATER = SimTimeNs(10**15)

Burst = tuple[int, bytes]
"""Time at which the first start bit begins, and the bytes, back to back."""


def split(bursts: list[Burst], baud: int) -> list[Frame | Malformed]:
    splitter = RtuSplitter()
    items = [item for at_ns, data in bursts for item in splitter.burst(data, SimTimeNs(at_ns), baud).items]
    return [*items, *splitter.silence(LATER)]  # type: ignore[list-item]


def one_by_one(bursts: list[Burst], baud: int) -> list[Frame | Malformed]:
    """Split bursts character by character, as a disturbed line is read."""
    splitter = RtuSplitter()
    items = []
    for at_ns, data in bursts:
        for place, byte in enumerate(data):
            times_ns = [at_ns + character_ns(place + 1, baud)]
            items += splitter.characters(bytes((byte,)), times_ns, baud).items
    return [*items, *splitter.silence(LATER)]  # type: ignore[list-item]


def end_ns(burst: Burst, baud: int) -> int:
    return burst[0] + character_ns(len(burst[1]), baud)


@pytest.mark.parametrize(
    ("body", "crc"),
    [
        (b"123456789", 0x4B37),  # the check value of CRC-16/MODBUS
        (bytes.fromhex("02 07"), 0x1241),  # Serial Line Guide, appendix B: sent as 41 12
        (bytes.fromhex("01 03 00 00 00 01"), 0x0A84),
    ],
)
def test_the_crc(body: bytes, crc: int) -> None:
    assert crc16(body) == crc
    assert encode(body[0], body[1], body[2:]) == body + bytes((crc & 0xFF, crc >> 8))


def test_the_silences() -> None:
    assert [(gap_ns(baud), silence_ns(baud)) for baud in (9600, 19200)] == [
        (1_562_500, 3_645_833),
        (781_250, 1_822_916),
    ]
    assert {(gap_ns(baud), silence_ns(baud)) for baud in (19201, 38400, 10**6)} == {(750_000, 1_750_000)}


@given(st.lists(FRAMES, min_size=1, max_size=5), BAUDS, st.data())
def test_frames_come_out_as_they_went_in_however_they_are_cut(
    frames: list[bytes], baud: int, data: st.DataObject
) -> None:
    at_ns, whole, cut = 0, [], []
    for frame in frames:
        whole.append((at_ns, frame))
        places = sorted(data.draw(st.sets(st.integers(1, len(frame) - 1), max_size=4)))
        cut += [
            (at_ns + character_ns(first, baud), frame[first:last])
            for first, last in pairwise([0, *places, len(frame)])
        ]
        at_ns = end_ns(whole[-1], baud) + silence_ns(baud) + data.draw(st.integers(0, 10**7))
    expected = [Frame(at_ns, frame) for at_ns, frame in whole]
    assert split(whole, baud) == split(cut, baud) == one_by_one(cut, baud) == expected
    assert not any(item.fault for item in expected)


@given(FRAMES, FRAMES, BAUDS)
def test_a_silence_is_one_from_its_limit_on(one: bytes, two: bytes, baud: int) -> None:
    first = (1000, one)
    for silence, expected in (
        (silence_ns(baud), [Frame(1000, one), "two"]),
        (silence_ns(baud) - 1, ["gap"]),
        (gap_ns(baud) + 1, ["gap"]),
    ):
        second = (end_ns(first, baud) + silence, two)
        items = split([first, second], baud)
        whole = one + two
        if expected == ["gap"]:
            pieces = [item.raw for item in items]
            assert b"".join(pieces) == whole
            assert {item.fault for item in items} == {"gap" if len(whole) <= 256 else "too long"}
        else:
            assert items == [Frame(1000, one), Frame(second[0], two)]
        assert items == one_by_one([first, second], baud)


@given(FRAMES, BAUDS, st.data())
def test_a_gap_within_a_frame_is_none_up_to_its_limit(frame: bytes, baud: int, data: st.DataObject) -> None:
    place = data.draw(st.integers(1, len(frame) - 1))
    first = (0, frame[:place])
    bursts = [first, (end_ns(first, baud) + gap_ns(baud), frame[place:])]
    assert split(bursts, baud) == one_by_one(bursts, baud) == [Frame(0, frame)]
    bursts[1] = (bursts[1][0] + 1, frame[place:])
    assert split(bursts, baud) == one_by_one(bursts, baud) == [Malformed(0, frame, "gap")]


@pytest.mark.parametrize("size", [1, 3, 4, 256, 257, 600])
def test_what_is_too_short_or_too_long_is_no_frame(size: int) -> None:
    raw = bytes(range(1, 101)) * 6
    items = split([(0, raw[:size]), (LATER // 2, encode(1, 2))], 9600)
    assert b"".join(item.raw for item in items[:-1]) == raw[:size]
    assert {item.fault for item in items[:-1]} == {
        "too short" if size < 4 else "CRC" if size <= 256 else "too long"
    }
    assert all(len(item.raw) <= 256 for item in items)
    assert (items[-1].fault, items[-1].raw) == ("", encode(1, 2))


def test_a_frame_is_over_when_the_silence_is() -> None:
    splitter = RtuSplitter()
    heard = splitter.burst(encode(17, 3), SimTimeNs(0), 9600)
    over_ns = character_ns(4, 9600) + silence_ns(9600)
    assert (heard.items, heard.addresses, heard.over_ns) == ([], (17,), over_ns)
    assert splitter.silence(SimTimeNs(over_ns - 1)) == []
    copy = splitter.copy()
    assert splitter.silence(SimTimeNs(over_ns)) == copy.silence(FOREVER) == [Frame(0, encode(17, 3))]
    assert splitter.silence(FOREVER) == []


def test_whom_a_frame_concerns() -> None:
    splitter = RtuSplitter()
    frame = encode(17, 3, b"\5\5")
    assert splitter.burst(frame[:2], SimTimeNs(0), 9600).addresses == (17,)
    rest_ns = SimTimeNs(character_ns(2, 9600))
    assert splitter.burst(frame[2:], rest_ns, 9600).addresses == (17,), (
        "it goes on, and does not begin with 5"
    )
    assert splitter.burst(encode(0, 3), LATER, 9600).addresses is None


def test_a_wrong_crc_is_seen_and_made() -> None:
    frame = encode(17, 3, b"\0\x6b\0\3")
    spoiled = MODBUS_RTU.fault("packet_bad_crc", 1.0, 1)(frame)
    assert spoiled[:-2] == frame[:-2]
    assert spoiled != frame
    assert MODBUS_RTU.fault("packet_bad_crc", 0.0, 1)(frame) == frame
    (item,) = split([(0, spoiled)], 9600)
    assert (item.is_packet, item.fault) == (True, "CRC")
    assert MODBUS_RTU.text(Frame(0, frame)) == "to 17: read holding registers 107 to 109"
    assert (
        MODBUS_RTU.text(item)
        == f"to 17: read holding registers 107 to 109  CRC {spoiled[-2:].hex(' ')} is wrong"
    )
    assert MODBUS_RTU.text(Malformed(0, b"\1", "too short")) == "malformed (too short): 01"


def test_fuzz_no_byte_is_lost_or_counted_twice() -> None:
    """Random bursts at random times, of a second reader too: it looks at all characters at once."""
    chance = random.Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    for _ in range(int(os.environ.get("HIL_FUZZ", "2000")) // 10):
        baud = chance.choice([1200, 9600, 19200, 38400, 10**6])
        at_ns, bursts = 0, []
        for _ in range(chance.randrange(1, 12)):
            data = chance.choice(
                [chance.randbytes(chance.choice([1, 3, 8, 200])), encode(chance.randrange(256), 3)]
            )
            bursts.append((at_ns, data))
            limits = [gap_ns(baud), silence_ns(baud)]
            at_ns = end_ns(bursts[-1], baud) + chance.choice(
                [0, *limits, *(limit + 1 for limit in limits), chance.randrange(2 * limits[1])]
            )
        items = split(bursts, baud)
        assert items == one_by_one(bursts, baud)
        assert b"".join(item.raw for item in items) == b"".join(data for _, data in bursts)
        assert [item.raw for item in items if item.is_packet] == model(bursts, baud)


def model(bursts: list[Burst], baud: int) -> list[bytes]:
    """Frames of a whole stream, right or wrong in their CRC."""
    frames, late = [bytearray()], [False]
    for index, (at_ns, data) in enumerate(bursts):
        silence = at_ns - end_ns(bursts[index - 1], baud) if index else 0
        if silence >= silence_ns(baud):
            frames.append(bytearray())
            late.append(False)
        late[-1] |= silence > gap_ns(baud) and len(frames[-1]) > 0
        frames[-1] += data
    return [
        bytes(raw) for raw, is_late in zip(frames, late, strict=True) if 4 <= len(raw) <= 256 and not is_late
    ]
