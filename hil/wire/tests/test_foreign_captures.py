"""Captures of other programs: pcap in all its forms, pcapng with blocks, links and times of their own."""

import struct
from contextlib import suppress
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.wire.outside_text import LeftOut
from hil.wire.pcap import read_pcap
from hil.wire.pcapng import CaptureError, Record, interfaces_in, read, split_blocks, whole_blocks

HEARTBEAT = bytes.fromhex("00000701 01000000 05")
FORMS = [(0xA1B2C3D4, 1000, 16), (0xA1B23C4D, 1, 16), (0xA1B2CD34, 1000, 24)]
SERIAL = bytes(8) + b"\2\0\0\0ab"


def pcap(link: int, *packets: bytes, order: str = "<", form: tuple[int, int, int] = FORMS[0]) -> bytes:
    magic, _, head = form
    data = struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, 65535, link)
    for packet in packets:
        data += struct.pack(order + "IIII", 17, 7000, len(packet), len(packet)) + bytes(head - 16) + packet
    return data


def block(kind: int, body: bytes, order: str = "<") -> bytes:
    body += bytes(-len(body) % 4)
    size = struct.pack(order + "I", 12 + len(body))
    return struct.pack(order + "I", kind) + size + body + size


def section(order: str = "<") -> bytes:
    return block(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1), order)


def interface(link: int, options: bytes = b"", order: str = "<") -> bytes:
    return block(1, struct.pack(order + "HHI", link, 0, 0) + options, order)


def packet(payload: bytes, ticks: int = 0, number: int = 0, order: str = "<") -> bytes:
    head = struct.pack(order + "IIIII", number, ticks >> 32, ticks & 0xFFFFFFFF, len(payload), len(payload))
    return block(6, head + payload, order)


def rows(data: bytes) -> tuple[list[Record], str]:
    left_out = LeftOut()
    read_all = read if data[:4] == b"\x0a\x0d\x0d\x0a" else read_pcap
    return list(read_all(data, left_out)), left_out.told()


@pytest.mark.parametrize(("order", "form"), [*product("<>", FORMS)])
def test_pcap_in_all_its_forms(order: str, form: tuple[int, int, int]) -> None:
    found, said = rows(pcap(227, HEARTBEAT, HEARTBEAT, order=order, form=form))
    assert [(each.at_ns, each.interface, each.data) for each in found] == [
        (17 * 10**9 + 7000 * form[1], "can0", HEARTBEAT)
    ] * 2
    assert not said


@pytest.mark.parametrize(("order", "link"), [*product("<>", (113, 276))])
def test_can_in_a_cooked_capture(order: str, link: int) -> None:
    in_order = struct.pack(order + "I", 0x701) + HEARTBEAT[4:]
    head = bytes(14) + b"\0\x0c" if link == 113 else b"\0\x0c" + bytes(18)
    other = bytes(14) + b"\x08\0" if link == 113 else b"\x08\0" + bytes(18)
    found, said = rows(pcap(link, head + in_order, other + bytes(20), order=order))
    assert [each.data for each in found] == [HEARTBEAT]
    assert said == "1 left out: byte 81: of protocol 0800h, which is no CAN".replace(
        "81", str(24 + 16 + len(head) + 9)
    )


def test_what_is_cut_off_or_something_else_is_said() -> None:
    data = pcap(227, HEARTBEAT, HEARTBEAT)
    for cut in (1, 9, 20):
        found = []
        with pytest.raises(CaptureError, match=f"cut off in the middle of a packet at byte {24 + 16 + 9}"):
            found.extend(each for each in read_pcap(data[:-cut], LeftOut()))
    with pytest.raises(CaptureError, match="cut off in its head"):
        rows(data[:10])
    found, said = rows(pcap(1, bytes(60), bytes(60)))
    assert found == []
    assert (
        said
        == "2 left out: byte 24 and 1 more: of link type 1, which is no CAN (227) and no serial line (250)"
    )


def test_pcapng_of_other_programs() -> None:
    for order in "<>":
        resolution = struct.pack(order + "HH", 9, 1) + b"\x83\0\0\0"  # eighths of a second
        since = struct.pack(order + "HHq", 14, 8, 100)
        data = (
            section(order)
            + interface(1, order=order)
            + interface(250, resolution + since, order)
            + packet(bytes(60), order=order)
            + packet(SERIAL, 12, 1, order)
            + packet(SERIAL, 12, 7, order)
            + block(5, bytes(8), order)
            + packet(b"short", 12, 1, order)
        )
        found, said = rows(data)
        assert [(each.at_ns, each.interface, each.event, each.data) for each in found] == [
            (101_500_000_000, "1", 2, b"ab")
        ]
        assert said.startswith("3 left out: ")


@pytest.mark.parametrize("size", [0, 4, 5000])
def test_an_offset_of_times_that_has_no_eight_bytes_is_none(size: int) -> None:
    since = struct.pack("<HH", 14, size) + b"\x7f" * size
    found, said = rows(section() + interface(227, since) + packet(HEARTBEAT, 5))
    assert [(each.at_ns, each.data) for each in found] == [(5000, HEARTBEAT)]
    assert not said


def test_older_and_simpler_blocks_have_packets_too() -> None:
    old = block(2, struct.pack("<HHIIII", 0, 0, 0, 5, 9, 9) + HEARTBEAT)
    simple = block(3, struct.pack("<I", 9) + HEARTBEAT)
    found, said = rows(section() + interface(227) + old + simple)
    assert [(each.at_ns, each.data) for each in found] == [(5000, HEARTBEAT), (0, HEARTBEAT)]
    assert not said


def test_the_end_of_data_is_data_where_it_has_some() -> None:
    def event(kind: int, data: bytes) -> bytes:
        return packet(bytes(8) + bytes((kind, 0, 0, 0)) + data)

    data = section() + interface(250) + event(3, b"a") + event(4, b"b") + event(3, b"")
    assert [each.event for each in rows(data)[0]] == [1, 2, 3]


GOOD = section() + interface(227) + packet(HEARTBEAT, 7) + interface(250) + packet(SERIAL, 8, 1)


@given(st.data())
def test_mutated_captures_are_read_or_refused(data: st.DataObject) -> None:
    good = data.draw(st.sampled_from((GOOD, pcap(227, HEARTBEAT), pcap(276, bytes(40), order=">"))))
    mutated = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        mutated[data.draw(st.integers(4, len(good) - 1))] = data.draw(st.integers(0, 255))
    content = bytes(mutated[: data.draw(st.integers(1, len(good)))])
    with suppress(CaptureError):
        rows(content)
    for take in (whole_blocks, interfaces_in, lambda each: list(split_blocks(each))):
        with suppress(CaptureError):
            take(content)
