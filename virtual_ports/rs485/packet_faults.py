"""Packet faults of a station that does not do its part. Pure and seeded."""

from collections.abc import Callable

from hil.wire.byte_faults import Chance
from hil.wire.packet import Packet, PacketDecoder, crc8, frame

ACK, NAK = b"\x06", b"\x15"
Transform = Callable[[bytes], bytes]
"""Change of a burst: its bytes in, those that go on the wire out; nothing: the station is silent."""


def packet_fault(kind: str, rate: float, seed: int) -> Transform:
    """Transformation of ``packet_bad_crc``, ``packet_no_ack`` or ``packet_nak``."""
    chance = Chance(seed)

    def one(packet: Packet) -> bytes:
        is_ack = packet.data == ACK
        if (kind != "packet_bad_crc" and not is_ack) or not chance.below(rate):
            return packet.raw
        if kind == "packet_no_ack":
            return b""
        if kind == "packet_nak":
            return frame(packet.destination, packet.origin, NAK, packet.crc != 0)
        right = crc8(packet.data)
        wrong = right ^ (1 + chance.bits() % 255) or right ^ 0xFF or 1  # 0 is none
        return Packet(packet.destination, packet.origin, packet.data, wrong, 0).raw

    def transform(burst: bytes) -> bytes:
        out, at = b"", 0
        for item in PacketDecoder().feed(burst):
            if isinstance(item, Packet):
                sent = one(item)
                out += burst[at : item.end - len(item.raw)] + sent
                at = item.end
                if sent != item.raw and item.crc == 0 and burst[at : at + 1] == b"\0":
                    at += 1  # idle behind what is not sent
        return out + burst[at:]

    return transform


class Phantom:
    """Phantom: another node with somebody's address, which acknowledges all that is sent there.
    ``answer(at_ns, raw)`` sends for it, at that time."""

    def __init__(self, address: int, baud: int, answer: Callable[[int, bytes], None]) -> None:
        self.baud_now = baud
        self._address = address
        self._answer = answer

    def hear(self, start_ns: int, data: bytes, baud: int) -> None:
        character_ns = 10 * 10**9 / baud
        for item in PacketDecoder().feed(data):
            if isinstance(item, Packet) and item.destination == self._address and item.data not in (ACK, NAK):
                at_ns = start_ns + round((item.end + 2) * character_ns)
                self._answer(at_ns, frame(item.origin, self._address, ACK if item.is_good else NAK, True))

    def hear_characters(self, characters: object) -> None:
        """Ignored: in a collision it understands nothing."""

    def retract(self, after_ns: int) -> None:
        """Ignored: it finishes an answer that it has begun."""
