"""A SAC past its cold start, with a device of the test's own at its network port."""

from device_profiles.sac.packet import Malformed, Packet, PacketDecoder, encode
from hil.testing import Bench

ACK, NAK, DC1, DC2 = b"\x06", b"\x15", b"\x11", b"\x12"
ONE = {"bench": "one", "devices": {"s1": {"profile": "sac"}}}


def characters_ns(count):
    return count * 10 * 10**9 // 38400


class Board:
    """One SAC past its cold start, with a device of the test's own at its network port."""

    def __init__(self, *setup: str, config=ONE, name="s1"):
        self.bench = Bench(config)
        self.terminal = self.bench.port(name)
        self.network = self.bench.port(name, "network")
        self.axis = self.bench.axis(name)
        self.bench.run(ms=1100)
        for line in setup:
            self.type(line)
        self.terminal.read()
        self.network.read()

    def type(self, line, ms=300.0):
        """Type a line, and return what the terminal shows in the next ``ms``."""
        self.terminal.write(line.encode() + b"\r")
        self.bench.run(ms=ms)
        return self.terminal.read()

    def packet(self, data, origin=1, destination=85, crc=True, ms=100.0):
        """The packets that a packet is answered with, as (destination, origin, data)."""
        return self.raw(encode(destination, origin, data, crc=crc), ms)

    def raw(self, data, ms=100.0):
        self.network.write(data)
        self.bench.run(ms=ms)
        return self.heard()

    def heard(self):
        return packets(self.network.read())


def packets(data):
    decoder = PacketDecoder()
    items = decoder.feed(data)
    assert decoder.pending == b""
    assert not any(isinstance(item, Malformed) for item in items)
    assert all(item.is_good for item in items)
    return [(item.destination, item.origin, item.data) for item in items if isinstance(item, Packet)]


def pulses(board):
    return board.axis.snapshot().pulses
