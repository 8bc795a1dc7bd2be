"""The packet codec: vectors, every kind of malformed input, and agreement with a second reader."""

import importlib.util
import os
import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from device_profiles.sac.packet import DATA_MAX, FAULTS, Malformed, Packet, PacketDecoder, crc8, encode

_spec = importlib.util.spec_from_file_location("packet_model", Path(__file__).with_name("packet_model.py"))
assert _spec
assert _spec.loader
model = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(model)

ADDRESSES = st.sampled_from([0, 1, *range(4, 256)])
DATA = st.binary(max_size=DATA_MAX).map(lambda data: bytes(byte for byte in data if byte not in (0, 2, 3)))

# The check value of CRC-8/MAXIM, and figures of the SAC's network.
CRCS = {
    b"123456789": 0xA1,
    b"\x06": 0xDD,
    b"\x15": 0xA2,
    b"\x11": 0xC3,
    b"\x12": 0x21,
    b"y": 0x64,
    b"m3000": 0x70,
    b"m13": 0x00,
    b"m132": 0x02,
    b"m349": 0x03,
}


@pytest.mark.parametrize(("data", "crc"), CRCS.items())
def test_crc(data, crc):
    assert crc8(data) == model.crc(data) == crc
    assert encode(85, 1, data) == b"\2\x55\1" + data + b"\3" + bytes((crc, 0))


def told(items):
    return [
        (item.fault, item.raw, item.end) if isinstance(item, Malformed) else ("", item.raw, item.end)
        for item in items
    ]


def read(*pieces):
    decoder = PacketDecoder()
    return [item for piece in pieces for item in decoder.feed(piece)], decoder.pending


Y = b"\2\x55\1y\3\x64\0"


@pytest.mark.parametrize(
    ("stream", "items"),
    [
        (Y, [("", Y)]),
        (b"\2\x55\1\3\0", [("", b"\2\x55\1\3\0")]),
        (b"\2\x55\1\3\0\0", [("", b"\2\x55\1\3\0")]),
        (b"\2\x55\1y\3\0" + Y, [("", b"\2\x55\1y\3\0"), ("", Y)]),
        (b"\2\x55\1m13\3\0" * 2, [("", b"\2\x55\1m13\3\0")] * 2),
        (b"\2\x55\1m13\3\0\0" * 2, [("", b"\2\x55\1m13\3\0")] * 2),
        (b"\2\x55\1y\3\0\0\0" + Y, [("", b"\2\x55\1y\3\0"), ("noise", b"\0"), ("", Y)]),
        (b"\2\x55\1y\3\0x\0" + Y, [("", b"\2\x55\1y\3\0"), ("noise", b"x\0"), ("", Y)]),
        (Y + b"\0" + Y, [("", Y), ("noise", b"\0"), ("", Y)]),
        (b"hello" + Y, [("noise", b"hello"), ("", Y)]),
        (b"\2" + Y, [("cut", b"\2"), ("", Y)]),
        (b"\2\x55" + Y, [("cut", b"\2\x55"), ("", Y)]),
        (b"\2\x55\1m30" + Y, [("cut", b"\2\x55\1m30"), ("", Y)]),
        (b"\2\3\1y\3\x64\0" + Y, [("address", b"\2\3"), ("noise", b"\1y\3\x64\0"), ("", Y)]),
        (b"\2\x55\3y\3\x64\0" + Y, [("address", b"\2\x55\3"), ("noise", b"y\3\x64\0"), ("", Y)]),
        (b"\2\x55\1y\0" + Y, [("no ETX", b"\2\x55\1y\0"), ("", Y)]),
        (b"\2\x55\1y\x64\0" + Y, [("no ETX", b"\2\x55\1y\x64\0"), ("", Y)]),
        (
            b"\2\x55\1" + b"m" * 81 + b"\3\0\0" + Y,
            [("too long", b"\2\x55\1" + b"m" * 81), ("noise", b"\3\0\0"), ("", Y)],
        ),
        (b"\2\x55\1" + b"m" * 80 + b"\3\0", [("", b"\2\x55\1" + b"m" * 80 + b"\3\0")]),
        (b"\2\x55\1" + b"m" * 80 + b"\3\x41\0", [("", b"\2\x55\1" + b"m" * 80 + b"\3\x41\0")]),
        (b"\2\x55\1y\3\x64" + Y, [("no NUL", b"\2\x55\1y\3\x64"), ("", Y)]),
        (b"\2\x55\1y\3" + Y, [("no NUL", b"\2\x55\1y\3"), ("", Y)]),
        (b"\2\x55\1y\3\x64." + Y, [("no NUL", b"\2\x55\1y\3\x64."), ("", Y)]),
        (b"\2\x55\1m132\3\2\0" + Y, [("", b"\2\x55\1m132\3\2\0"), ("", Y)]),
        (b"\2\x55\1m349\3\3\0", [("", b"\2\x55\1m349\3\3\0")]),
        (b"x" * 90 + Y, [("noise", b"x" * 86), ("noise", b"xxxx"), ("", Y)]),
    ],
)
def test_every_kind_of_input(stream, items):
    got, pending = read(stream)
    assert [(fault, raw) for fault, raw, _ in told(got)] == items
    assert pending == b""
    assert told(got) == model.read(stream)[0]


def test_a_wrong_crc_is_seen_and_a_zero_one_is_not_looked_at():
    for crc, is_good in ((0x64, True), (0x65, False), (2, False), (0, True)):
        [packet], _ = read(b"\2\x55\1y\3" + bytes((crc, 0)).removeprefix(b"\0"))
        assert isinstance(packet, Packet)
        assert (packet.crc, packet.is_good) == (crc, is_good)


@given(ADDRESSES, ADDRESSES, DATA, st.booleans())
def test_what_was_encoded_is_decoded(destination, origin, data, crc):
    raw = encode(destination, origin, data, crc=crc)
    [packet], pending = read(raw)
    assert pending == b""
    check = model.crc(data) if crc else 0
    end = len(raw) - (crc and check == 0)  # of ETX NUL NUL the last is idle
    assert packet == Packet(destination, origin, data, check, end)
    assert packet.is_good
    assert packet.raw == raw[:end]
    assert raw[-2:] == b"\3\0" or crc


@given(ADDRESSES, DATA, st.booleans())
def test_a_packet_is_given_with_its_last_byte_and_no_later(origin, data, crc):
    raw = encode(85, origin, data, crc=crc)
    decoder = PacketDecoder()
    given_at = [n for n, byte in enumerate(raw, start=1) for _ in decoder.feed(bytes((byte,)))]
    assert given_at == [raw.index(b"\3") + (2 if not crc or crc8(data) == 0 else 3)]
    assert [item.origin for item in decoder.feed(encode(85, 1, b"y"))] == [1]  # also right behind it


@pytest.mark.parametrize(
    ("destination", "origin", "data"),
    [(2, 1, b""), (3, 1, b""), (1, 3, b""), (256, 1, b""), (-1, 1, b""), (4, 1, b"m" * 81)]
    + [(4, 1, bytes((byte,))) for byte in (0, 2, 3)],
)
def test_what_no_packet_can_carry_is_refused(destination, origin, data):
    with pytest.raises(ValueError, match=r"address|at most|STX"):
        encode(destination, origin, data)


@given(st.lists(st.sampled_from([b"\0", b"\2", b"\3", b"\x55", b"m", Y, b"z" * 40]), max_size=40))
def test_no_byte_but_an_idle_one_is_lost_in_what_it_gives(pieces):
    items, pending = read(*pieces)
    stream = b"".join(pieces)
    at = 0
    for item in items:
        start = item.end - len(item.raw)
        assert stream[start : item.end] == item.raw
        assert stream[at:start] in (b"", b"\0")
        at = item.end
    assert stream[at:] in (pending, b"\0" + pending)
    assert len(pending) < 87


def garbled(rng: random.Random) -> bytes:
    """Random packets, damaged: bytes flipped, dropped, doubled, inserted."""
    stream = bytearray()
    for _ in range(rng.randrange(1, 4)):
        data = bytes(rng.choices(b"m30ys\x06\x11\x15", k=rng.choice((0, 1, 1, 3, 8, 79, 80, 81, 82))))
        stream += b"\2%c%c%b\3%b\0" % (
            rng.choice((0, 1, 2, 3, 85)),
            rng.choice((1, 2, 3, 86)),
            data,
            rng.choice((b"", b"\0", b"\2", b"\3", bytes((model.crc(data[-4:]),)), bytes((crc8(data),)))),
        )
    for _ in range(rng.choice((0, 0, 1, 1, 2, 5))):
        at = rng.randrange(len(stream) + 1)
        length = rng.choice((0, 1, 1, 3))
        stream[at : at + length] = bytes(rng.choices(b"\0\2\3Um", k=rng.choice((0, 1, 1, 3, 90))))
    return bytes(stream)


@pytest.mark.thorough
@pytest.mark.long
def test_fuzz():
    """HIL_FUZZ inputs, each in random pieces, against the second reader."""
    rng = random.Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    seen = dict.fromkeys(FAULTS, 0)
    for _ in range(int(os.environ.get("HIL_FUZZ", "25000"))):
        stream = garbled(rng)
        cuts = sorted(rng.choices(range(len(stream) + 1), k=rng.randrange(4)))
        items, pending = read(*(stream[i:j] for i, j in zip([0, *cuts], [*cuts, len(stream)], strict=True)))
        assert (told(items), pending) == model.read(stream), stream
        for item in items:
            if isinstance(item, Packet):
                assert item.is_good == (item.crc in (0, model.crc(item.data)))
                seen[""] += 1
            else:
                seen[item.fault] += 1
    assert min(seen.values()) > 0, seen
