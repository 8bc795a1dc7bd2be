"""Commands of USB/IP that no host sends: each is answered once, or ends the attachment; nothing else happens.

``HIL_FUZZ`` sets how many are tried (100,000; ``make fuzz``: 10,000,000), ``HIL_FUZZ_SEED`` where they start.
"""

import os
import random
import struct

import pytest
from linux_host import LinuxHost

from hil.vocab.ports import ADAPTER, UsbIdentity
from virtual_ports.usb.cdc_acm import CdcAcm
from virtual_ports.usb.descriptors import Descriptors
from virtual_ports.usb.urb import (
    HEADER_BYTES,
    MOST_TRANSFER_BYTES,
    CommandReader,
    ProtocolError,
    Submit,
    Unlink,
)

CASES = int(os.environ.get("HIL_FUZZ", "100000"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
NATIVE = UsbIdentity(0x2341, 0x804D, "m", "p", is_native=True)
REQUEST_TYPES = (0x00, 0x01, 0x02, 0x21, 0x80, 0x81, 0x82, 0xA1, 0x40, 0xC3)
VALUES = (0, 1, 2, 3, 0x100, 0x200, 0x300, 0x301, 0x303, 0x304, 0x600, 1200, 0xFFFF)
WHERE = (0, 1, 2, 3, 0x81, 0x02, 0x83, 0x0409, 0xFFFF)
LENGTHS = (0, 1, 2, 7, 8, 18, 64, 255)


def submit_header(length: int, endpoint: int = 0, direction: int = 1, packets: int = 0) -> bytes:
    return struct.pack(">IIIIIIiiii8s", 1, 5, 7, direction, endpoint, 0, length, 0, packets, 0, bytes(8))


@pytest.mark.parametrize("identity", [ADAPTER, NATIVE])
def test_fuzz_each_transfer_is_answered_once(identity: UsbIdentity) -> None:
    """``HIL_FUZZ`` transfers and unlinks. The host checks the answers: none comes twice, none is too long."""
    chance = random.Random(SEED)
    host, device = LinuxHost(), CdcAcm(Descriptors(identity, "s"))
    host.enumerate()
    statuses: set[int] = set()

    def done(status: int, data: bytes) -> None:
        statuses.add(status)

    asked: list[int] = []
    for case in range(CASES // 2):
        what = chance.random()
        if what < 0.1 and asked:
            host.unlink(chance.choice(asked))
        elif what < 0.5:
            length = chance.choice(LENGTHS)
            setup = struct.pack(
                "<BBHHH",
                chance.choice(REQUEST_TYPES),
                chance.choice((*range(12), *range(0x20, 0x24), 255)),
                chance.choice(VALUES),
                chance.choice(WHERE),
                length if chance.random() < 0.9 else chance.choice(LENGTHS),
            )
            is_in = bool(setup[0] & 0x80) == (chance.random() < 0.95)
            data = length if is_in else chance.randbytes(length)
            asked.append(host.submit(0, is_in, data, done, setup))
        else:
            endpoint, length = chance.choice((1, 2, 2, 2, 3, 3, 3, 4, 15)), chance.choice(LENGTHS)
            is_in = (endpoint != 2) == (chance.random() < 0.95)
            data = length if is_in else chance.randbytes(length)
            asked.append(host.submit(endpoint, is_in, data, done, flags=chance.choice((0, 1, 0x40))))
        if chance.random() < 0.2:
            device.to_host.send(chance.randbytes(chance.choice(LENGTHS)))
            device.tell(chance.choice((0, 16, 32)))
            device.from_host.drain(chance.choice(LENGTHS))
        if chance.random() < 0.3:
            device.receive(host.take())
            host.receive(device.take_answers())
        if case % 1000 == 0:
            device.to_host.queue.clear()
            device.from_host.drain(1 << 30)
            del asked[:-20]
    assert {0, -32, -104, -121} <= statuses or CASES < 10_000
    device.receive(host.take())
    host.receive(device.take_answers())
    for seqnum in list(host.urbs):
        host.unlink(seqnum)
    device.receive(host.take())
    host.receive(device.take_answers())
    assert host.urbs == {}


def test_fuzz_garbage_ends_the_attachment_and_nothing_else() -> None:
    """A twentieth of ``HIL_FUZZ`` mutated streams: they are commands, or a ProtocolError."""
    chance = random.Random(SEED)
    ends = 0
    for _ in range(CASES // 20):
        stream = bytearray(submit_header(4, 2, 0) + b"abcd" + struct.pack(">6I24x", 2, 6, 7, 0, 0, 5))
        stream += submit_header(chance.choice(LENGTHS), 3)
        for _ in range(chance.randrange(4)):
            stream[chance.randrange(len(stream))] = chance.randrange(256)
        pieces = (*chance.choices(range(1, 60), k=6), len(stream))
        device, at = CdcAcm(Descriptors(ADAPTER, "s")), 0
        try:
            for size in pieces:
                device.receive(bytes(stream[at : at + size]))
                at += size
        except ProtocolError:
            ends += 1
        assert len(device.take_answers()) % HEADER_BYTES in range(HEADER_BYTES)
    assert 0 < ends < CASES // 20


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (bytes(HEADER_BYTES), "command 0x0 is none of USB/IP"),
        (b"GET / HTTP/1.1\r\n" + bytes(HEADER_BYTES), "command 0x47455420 is none"),
        (submit_header(-1), "a transfer of -1 bytes is impossible"),
        (submit_header(MOST_TRANSFER_BYTES + 1), "a transfer of 16777217 bytes is impossible"),
        (submit_header(1, 16), "no endpoint 16 in direction 1"),
        (submit_header(1, 1, 2), "no endpoint 1 in direction 2"),
        (submit_header(1, 1, 1, 3), "a transfer of 3 packets: no endpoint is isochronous"),
    ],
)
def test_what_no_host_sends_is_no_command(header: bytes, says: str) -> None:
    with pytest.raises(ProtocolError, match=says):
        list(CommandReader().read(header))


def test_commands_before_a_wrong_one_are_read() -> None:
    reader = CommandReader()
    good = (
        submit_header(3, 2, 0) + b"abc" + struct.pack(">6I24x", 2, 6, 7, 0, 0, 5) + submit_header(9, 3, 1, -1)
    )
    commands = reader.read(good + bytes(HEADER_BYTES))
    read = [next(commands) for _ in range(3)]
    with pytest.raises(ProtocolError):
        next(commands)
    assert read == [
        Submit(5, 2, False, 0, 3, bytes(8), b"abc"),
        Unlink(6, 5),
        Submit(5, 3, True, 0, 9, bytes(8)),
    ]


def test_commands_come_in_any_pieces() -> None:
    stream = (
        submit_header(3, 2, 0) + b"abc" + submit_header(0, 2, 0) + struct.pack(">6I24x", 2, 6, 7, 0, 0, 5)
    )
    whole = list(CommandReader().read(stream))
    assert len(whole) == 3
    reader = CommandReader()
    assert [command for byte in stream for command in reader.read(bytes((byte,)))] == whole
