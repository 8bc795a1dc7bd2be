"""Nodes of a line as the master of the line speaks with them: commands to bytes, packets to what they mean.

A kind of board whose boards share a line says this of itself (``Profile.line_nodes``); ``hil.master`` asks
it, and knows no packet.
"""

from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple, Protocol

from hil.vocab.dialogue import Dialogue
from hil.vocab.framing import Framing, Item


class Signal(StrEnum):
    """Meaning of a packet for the master of the line."""

    DONE = "ACK"
    """The node has the packet before this one, and carries it out."""
    REFUSED = "NAK"
    """The node has refused the packet before this one, and does not carry it out."""
    BEGUN = "DC1"
    """The node begins a command now."""
    ENDED = "DC2"
    """The node has ended a command now."""
    TEXT = "text"
    """Words for people."""
    COMMAND = "command"
    """A command for another node: somebody else sends on the line."""


class LinePacket(NamedTuple):
    """Packet of a line. ``is_checked``: true if its checksum is there and right."""

    origin: int
    destination: int
    signal: Signal
    text: str
    is_checked: bool


class LineNodes(Protocol):
    """Kind of nodes on a line: what they understand, and what they say."""

    @property
    def framing(self) -> Framing:
        """Framing of the line."""

    @property
    def baud(self) -> int:
        """Usual speed of the line."""

    @property
    def character_bits(self) -> int:
        """Bits of a character, start and stop included."""

    @property
    def master(self) -> int:
        """Address of the line's master."""

    @property
    def to_all(self) -> int:
        """Address of everybody, which nobody answers."""

    @property
    def addresses(self) -> Sequence[int]:
        """Addresses that a node can have, in order."""

    @property
    def turnaround_characters(self) -> int:
        """Delay from a packet's last bit to the first of its answer, in characters."""

    @property
    def answer_bytes(self) -> int:
        """Length of the longest answer."""

    @property
    def signal_bytes(self) -> int:
        """Length of the longest packet that a node sends by itself; 0: it sends none."""

    @property
    def busy_ns(self) -> int:
        """Maximum delay of the answer of a node that does something else first."""

    @property
    def queue_length(self) -> int:
        """Number of commands that can wait in a node; it drops what comes then, and does not say so."""

    @property
    def probe(self) -> bytes:
        """Command that a node answers, and that changes nothing in it."""

    @property
    def release(self) -> bytes:
        """Command that lets motions begin that wait for the sync."""

    @property
    def stop_gracefully(self) -> bytes:
        """Command that ends all motion with the deceleration that was set, and drops what waits."""

    @property
    def stop_at_once(self) -> bytes:
        """Command that ends all motion at once, and drops what waits."""

    def encode(self, destination: int, command: bytes) -> bytes:
        """Encode a packet from the master. Raises ValueError: an address that no node has, or bytes that no
        packet can have."""

    def text(self, words: str) -> bytes:
        """Encode words for people as a command that shows them at a node. Raises ValueError."""

    def read(self, item: Item) -> LinePacket | None:
        """Read an item of the framing's splitter; None: its checksum is wrong, or it is no packet."""

    def may_repeat(self, command: bytes) -> bool:
        """Answer whether a node that gets a command twice is where it would be after the first time."""

    def moves(self, command: bytes) -> bool:
        """Answer whether a command begins a motion, which a node may tell about by ``Signal.BEGUN``."""

    def tells_from(self, command: bytes) -> bool | None:
        """Answer whether a node that has taken a command tells from then on when commands begin and end;
        None: the command has no say in that."""

    def deceleration(self, rad_per_s2: float) -> bytes:
        """Command that sets the motor's deceleration for a controlled stop, as near as it can be set."""

    def queue_upload(self, content: bytes, file: str, steps_per_rev: int | None) -> "NodeUpload":
        """Read a file with a queue for nodes. ``steps_per_rev``: of their motors; None: the usual number.

        Raises:
            Refusal: a line ``file:line:column: what; remedy`` for each problem.
        """

    def address_at_terminal(self) -> Dialogue[int]:
        """Ask a board at its terminal for its address on the line."""


class NodeUpload(Protocol):
    """Queue that is written into nodes over their line, and can be read back at their terminals."""

    @property
    def commands(self) -> Sequence[bytes]:
        """Commands that write it, each of which may come twice."""

    def differences(self) -> Dialogue[Sequence[str]]:
        """Compare it with what a board lists at its terminal; a line for each difference."""


class LineMaster(Protocol):
    """Master of a line without I/O: of SACs, of Modbus, or a run over a line."""

    def receive(self, data: bytes, at_ns: int) -> None:
        """Take bytes of the line, the last of which came at ``at_ns``."""

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do; ``FOREVER``: nothing."""

    def advance(self, now_ns: int) -> None:
        """Do what is due."""

    def to_send(self) -> bytes:
        """Bytes that go out now."""

    def lose(self, at_ns: int, why: str) -> None:
        """Note that the port has gone."""
