"""SACs as nodes of a line: ``hil.vocab.line_node.LineNodes``, for the master of the line.

Sources: SAC user manual, communications, network, ACK, soft_ops, Appendix C. Decisions: README.md.
"""

import re
from collections.abc import Sequence

from device_profiles.sac import companion
from device_profiles.sac.companion_files import Row, read_queue
from device_profiles.sac.framing import FRAMING, TURNAROUND_CHARACTERS
from device_profiles.sac.network import ACK, BROADCAST, DC1, DC2, NAK
from device_profiles.sac.packet import DATA_MAX, FRAME_BYTES, Packet, crc8, encode
from device_profiles.sac.parameters import FACTORY_BAUD
from hil.vocab.dialogue import Dialogue, Refusal
from hil.vocab.framing import Item
from hil.vocab.line_node import LinePacket, Signal
from hil.vocab.time import NS_PER_MS

MASTER = 1
ADDRESSES = range(4, 256)
"""Addresses of nodes: 0 is everybody, 1 the master (the manual's mother), 2 and 3 are characters of the frame
(manual, device ID)."""
QUEUE_LENGTH = 30
BUSY_NS = 500 * NS_PER_MS
"""Maximum delay of an answer: a listing of 30 rows keeps a board for 0.4 s at 38400 baud."""
STEPS_PER_REV = 200
"""Steps of a motor's turn, the factory's setting a."""
LEAST_DEC, MOST_DEC = 0.01, 998.0
"""Bounds of a deceleration in rad/s2: 0 and 999 are no ramp (manual, acceleration)."""
_SIGNALS = {ACK: Signal.DONE, NAK: Signal.REFUSED, DC1: Signal.BEGUN, DC2: Signal.ENDED}
_TEXTS = b" ."
_END = b" "
"""Character that ends a command: what follows it is not read."""
_REPEATABLE = re.compile(
    rb"""
    [aAdD][0-9.]* | [vV]c?[0-9]* | [vV][dD]         # defaults of the session, and a query
    | [sS] | l                                      # ends of motion
    | [qQ][0-9]+[^ ]* | [qQ][sSrRcC]?               # rows by their numbers, save, restore, clear
    | [cC][cCfF] | [xX][dD]                         # queries
    | \$[FPRE] | \$[HKLO][0-9] | \$C[A-Za-z][^ ]+   # settings by their values
    """,
    re.VERBOSE,
)
"""Commands that may come twice. All others may not: motions, next, release, loops, toggles, undo."""
_MOTION = re.compile(rb"[mM]|[xX][mM0-9lL]|l[sSfFnNaA0-9]|[nNy]")

_SOFT_OPS = re.compile(rb"\$O([0-9])")


class SacQueue:
    """Queue of 30 rows for nodes: ``hil.vocab.line_node.NodeUpload``."""

    def __init__(self, rows: Sequence[Row], steps_per_rev: int) -> None:
        self._rows = rows
        self.commands = [row.command(steps_per_rev).encode() for row in rows]

    def differences(self) -> Dialogue[list[str]]:
        return companion.differences(self._rows)


class SacNodes:
    framing = FRAMING
    baud = FACTORY_BAUD
    character_bits = 10
    master = MASTER
    to_all = BROADCAST
    addresses = ADDRESSES
    turnaround_characters = TURNAROUND_CHARACTERS
    answer_bytes = FRAME_BYTES + 1
    signal_bytes = FRAME_BYTES + 1
    busy_ns = BUSY_NS
    queue_length = QUEUE_LENGTH
    probe = b"vd"
    release = b"y"
    stop_gracefully = b"s"
    stop_at_once = b"S"

    def encode(self, destination: int, command: bytes) -> bytes:
        """Encode a packet. A command whose CRC is 0, which nobody would check, gets a blank behind it."""
        if destination != BROADCAST and destination not in ADDRESSES:
            raise ValueError(f"{destination} is no node's address: they are 4 to 255, and 0 for all")
        if not command:
            raise ValueError("an empty command: nothing would happen")
        if crc8(command) == 0 and len(command) < DATA_MAX:
            command += _END
        return encode(destination, MASTER, command)

    def text(self, words: str) -> bytes:
        try:
            data = b" " + words.encode("latin-1")
        except UnicodeEncodeError as error:
            raise ValueError(f"{error.object[error.start]!r} cannot be sent: SACs have Latin-1") from None
        encode(BROADCAST, MASTER, data)
        return data

    def read(self, item: Item) -> LinePacket | None:
        if not isinstance(item, Packet) or not item.is_good:
            return None
        signal = _SIGNALS.get(item.data)
        data = item.data
        if signal is None:
            signal = Signal.TEXT if data[:1] and data[0] in _TEXTS else Signal.COMMAND
            data = data[1:] if signal is Signal.TEXT else data
        return LinePacket(item.origin, item.destination, signal, data.decode("latin-1"), item.crc != 0)

    def may_repeat(self, command: bytes) -> bool:
        return _REPEATABLE.fullmatch(command.partition(_END)[0]) is not None

    def moves(self, command: bytes) -> bool:
        return _MOTION.match(command) is not None

    def tells_from(self, command: bytes) -> bool | None:
        told = _SOFT_OPS.match(command)
        return told and told[1] != b"0"

    def deceleration(self, rad_per_s2: float) -> bytes:
        return b"d%.2f" % min(max(rad_per_s2, LEAST_DEC), MOST_DEC)

    def queue_upload(self, content: bytes, file: str, steps_per_rev: int | None) -> SacQueue:
        queue, steps = read_queue(content, file), steps_per_rev or STEPS_PER_REV
        problems = [
            f"{where}:1: RPM {row.rpm} and cycle {row.cycle_us} contradict each other at {steps} steps a"
            " turn; write the pair of this motor, or its steps with --steps-per-rev"
            for row, where in zip(queue.rows, queue.where, strict=True)
            if not row.is_possible(steps)
        ]
        if problems:
            raise Refusal("\n".join(problems))
        return SacQueue(queue.rows, steps)

    def address_at_terminal(self) -> Dialogue[int]:
        return companion.device_id()


NODES = SacNodes()
