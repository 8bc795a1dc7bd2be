"""TCP's header: the same packets however a stream is cut, and which fault ends it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.mbap import MbapPacket, MbapSplitter, encode

PACKETS = st.lists(
    st.builds(MbapPacket, st.integers(0, 0xFFFF), st.integers(0, 255), st.binary(min_size=1, max_size=253)),
    max_size=6,
)


def fed(stream: bytes, sizes: list[int]) -> tuple[list[MbapPacket], str]:
    """Packets and fault of a stream in pieces of these sizes, then the rest."""
    splitter, packets = MbapSplitter(), []
    for size in sizes:
        packets += splitter.feed(stream[:size])
        stream = stream[size:]
    return packets + splitter.feed(stream), splitter.fault


@given(PACKETS, st.lists(st.integers(0, 300), max_size=20), st.binary(max_size=5))
def test_packets_come_out_as_they_went_in(packets: list[MbapPacket], sizes: list[int], rest: bytes) -> None:
    stream = b"".join(encode(*packet) for packet in packets) + rest
    assert fed(stream, []) == fed(stream, sizes) == fed(stream, [1] * len(stream)) == (packets, "")


@pytest.mark.parametrize(
    ("header", "fault"),
    [
        ("0001 0001 0006", "protocol 1; Modbus is 0"),
        ("4745 5420 2f20", "protocol 21536; Modbus is 0"),  # GET /
        ("0001 0000 0000", "a length of 0; it is 2 to 254"),
        ("0001 0000 0001", "a length of 1; it is 2 to 254"),
        ("0001 0000 00ff", "a length of 255; it is 2 to 254"),
        ("0001 0000 ffff", "a length of 65535; it is 2 to 254"),
    ],
)
@pytest.mark.parametrize("size", [1, 5, 100])
def test_a_fault_is_said_and_ends_the_stream(header: str, fault: str, size: int) -> None:
    good = MbapPacket(7, 1, b"\3\0\0\0\1")
    stream = encode(*good) + bytes.fromhex(header) + encode(*good)
    assert fed(stream, [size] * len(stream)) == ([good], fault)


@given(st.lists(st.binary(max_size=600), max_size=5))
def test_any_bytes_are_packets_or_a_fault(pieces: list[bytes]) -> None:
    splitter = MbapSplitter()
    packets = [packet for piece in pieces for packet in splitter.feed(piece)]
    stream = b"".join(pieces)
    said = b"".join(encode(*packet) for packet in packets)
    assert stream.startswith(said)
    assert splitter.fault or len(stream) - len(said) < 260


@pytest.mark.parametrize(("transaction", "unit", "size"), [(0, 0, 0), (0, 0, 254), (65536, 0, 1), (0, -1, 1)])
def test_what_does_not_fit_is_not_encoded(transaction: int, unit: int, size: int) -> None:
    with pytest.raises(ValueError, match=r"a PDU|the header"):
        encode(transaction, unit, bytes(size))
