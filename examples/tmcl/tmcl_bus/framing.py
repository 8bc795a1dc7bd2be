"""Framing of TMCL: ``hil.vocab.framing.Framing``."""

from collections.abc import Iterator

from hil.vocab.framing import Item, Party, Transform
from hil.wire.byte_faults import Chance
from tmcl_bus.frames import (
    FRAME_BYTES,
    HOST,
    STATUSES,
    Command,
    Reply,
    Status,
    has_right_sum,
    reply_of,
    request_of,
)
from tmcl_bus.splitter import Frame, TmclSplitter
from tmcl_bus.words import reply_words, request_words

_GHOST_CHARACTERS = 2
"""Delay of a ghost's reply, in characters: chosen."""
_COMMANDS = frozenset(map(int, Command))


class TmclFraming:
    """Framing of frames of nine bytes."""

    name = "tmcl"
    faults = ("packet_bad_crc", "packet_no_ack", "node_clash")
    has_ends = False

    def splitter(self) -> TmclSplitter:
        return TmclSplitter()

    def ends(self, data: bytes, before: bytes | None) -> tuple[int, ...]:
        """Answer none: no byte ends a frame."""
        return ()

    def may_end(self, data: bytes) -> bool:
        return False

    def text(self, item: Item) -> str:
        if not isinstance(item, Frame):
            return f"malformed ({item.fault}): {item.raw.hex(' ')}"
        if item.is_text:
            return f"from {item.asked[0]}: {item.raw[1:].decode('ascii')}"
        said = reply_words(reply_of(item.raw)) if item.asked else request_words(request_of(item.raw))
        return said if has_right_sum(item.raw) else f"{said}  checksum {item.raw[-1]:02x} is wrong"

    def parties(self, item: Item) -> tuple[Party, Party]:
        """Answer the module as the receiver of a request, or as the sender of a reply."""
        if not isinstance(item, Frame):
            return None, None
        return (item.asked[0], item.raw[0]) if item.asked else (None, item.raw[0])

    def fault(self, kind: str, rate: float, seed: int) -> Transform:
        """Make ``packet_bad_crc``, a wrong sum, or ``packet_no_ack``, no reply."""
        chance = Chance(seed)

        def wrong_sum(burst: bytes) -> bytes:
            if len(burst) != FRAME_BYTES or not chance.below(rate):
                return burst
            return burst[:-1] + bytes((burst[-1] ^ (1 + chance.bits() % 0xFF),))

        def no_reply(burst: bytes) -> bytes:
            has_form = len(burst) == FRAME_BYTES and burst[2] in STATUSES and burst[3] in _COMMANDS
            return b"" if has_form and chance.below(rate) else burst

        return wrong_sum if kind == "packet_bad_crc" else no_reply

    def answers(self, burst: bytes, address: int) -> Iterator[tuple[int, bytes]]:
        """Reply to each request to the address that it was carried out."""
        for at in range(0, len(burst) - FRAME_BYTES + 1, FRAME_BYTES):
            raw = burst[at : at + FRAME_BYTES]
            request = request_of(raw)
            if request.module == address and has_right_sum(raw):
                reply = Reply(HOST, address, Status.OK, request.command, request.value)
                yield at + FRAME_BYTES + _GHOST_CHARACTERS, reply.encode()


TMCL_FRAMING = TmclFraming()
