"""Framing of the SAC's network: ``hil.vocab.framing.Framing``, over the codec of ``packet.py``."""

from collections.abc import Iterator

from device_profiles.sac.packet import Malformed, Packet, PacketDecoder, frame
from device_profiles.sac.packet_faults import ACK, KINDS, NAK, packet_fault
from device_profiles.sac.packet_text import packet_fields, packet_text
from hil.vocab.framing import EVERYBODY, Item, Party, Transform
from hil.vocab.packet_field import Fields

NUL, ETX = 0, 3
TURNAROUND_CHARACTERS = 2
"""Delay between a packet's last bit and its acknowledgement's first, in characters (decision)."""


class SacFraming:
    name = "sac"
    faults = (*KINDS, "node_clash")
    has_ends = True

    def splitter(self) -> PacketDecoder:
        return PacketDecoder()

    def ends(self, data: bytes, before: bytes | None) -> list[int]:
        """Answer where NUL ends a packet: right behind ETX, or with its CRC between. Elsewhere it is the
        address of everybody, or idle."""
        stream = (before or b"") + data
        first = len(stream) - len(data)
        return [
            place - first
            for place in range(first, len(stream))
            if stream[place] == NUL and (before is None or place < 2 or _is_end(stream[place - 2 : place]))
        ]

    def may_end(self, data: bytes) -> bool:
        return NUL in data

    def text(self, item: Item) -> str:
        assert isinstance(item, Packet | Malformed)
        return packet_text(item)

    def fields(self, item: Item) -> Fields:
        assert isinstance(item, Packet | Malformed)
        return packet_fields(item)

    def parties(self, item: Item) -> tuple[Party, Party]:
        if not isinstance(item, Packet):
            return None, None
        return item.origin, EVERYBODY if item.destination == 0 else item.destination

    def fault(self, kind: str, rate: float, seed: int) -> Transform:
        return packet_fault(kind, rate, seed)

    def answers(self, burst: bytes, address: int) -> Iterator[tuple[int, bytes]]:
        """Acknowledge every packet to the address but signals, as a node does."""
        for item in PacketDecoder().feed(burst):
            if isinstance(item, Packet) and item.destination == address and item.data not in (ACK, NAK):
                answer = frame(item.origin, address, ACK if item.is_good else NAK, True)
                yield item.end + TURNAROUND_CHARACTERS, answer


def _is_end(before: bytes) -> bool:
    """Answer whether NUL ends what ETX has announced, two bytes standing before it."""
    return before[1] == ETX or (before[0] == ETX and before[1] != NUL)


FRAMING = SacFraming()
