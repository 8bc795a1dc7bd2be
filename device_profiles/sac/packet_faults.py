"""Packet faults of a station that does not do its part. Pure and seeded."""

from device_profiles.sac.packet import Packet, PacketDecoder, crc8, frame
from hil.vocab.framing import Transform
from hil.wire.byte_faults import Chance

ACK, NAK = b"\x06", b"\x15"
KINDS = ("packet_bad_crc", "packet_no_ack", "packet_nak")


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
                    at += 1  # skip the idle NUL behind a packet that is not sent
        return out + burst[at:]

    return transform
