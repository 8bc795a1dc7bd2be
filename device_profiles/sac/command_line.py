"""Command line of the SAC: execution of a terminal's line, or of a packet of the network.

Sources: the SAC user manual, Appendix C and the chapter Command Detail.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from device_profiles.sac.eeprom import Memory
from device_profiles.sac.moves import Moves
from device_profiles.sac.network import BROADCAST, NAK, SEPARATORS, Network, is_signal
from device_profiles.sac.packet import Packet
from device_profiles.sac.queue_memory import QueueMemory
from device_profiles.sac.session import Session
from device_profiles.sac.system_commands import SystemCommands
from device_profiles.sac.terminal import Steps, Terminal
from device_profiles.sac.typed_text import Text
from hil.vocab.framing import Item
from hil.vocab.motion import Motion
from hil.vocab.time import SimTimeNs


class Command(NamedTuple):
    """Entry of the command table, by a line's first letters; ``run`` gets the rest of the line."""

    letters: str
    about: str
    run: Callable[["CommandLine", Text], Steps | None]
    quick: Callable[["CommandLine", str], object] | None = None
    """``run`` of a command that takes no time and writes nothing when it comes over the network."""


@dataclass(eq=False)
class CommandLine:
    """Executor of lines; ``now`` tells the simulated time."""

    motion: Motion
    session: Session
    terminal: Terminal
    network: Network
    memory: Memory
    system: SystemCommands
    now: Callable[[], SimTimeNs]

    def __post_init__(self) -> None:
        self.queue = QueueMemory(self.motion, self.session)
        self.moves = Moves(self.motion, self.session, self.queue)

    def single_pulse(self, byte: int) -> bool:
        """Make a single pulse by ``+`` or ``-``, which need no line end (manual, communications)."""
        if byte not in b"+-" or self.terminal.mode is not None:
            return False
        self.motion.pulse(byte == ord("-"))
        return True

    def execute(self, line: str) -> Steps | None:
        """Execute a terminal's line: the network's if an address begins it, else up to its first blank."""
        text = Text(line.partition(" ")[0])
        if self.terminal.mode is not None:
            return self._in_mode(self.terminal.mode, text)
        if self.network.typed(line):
            return None
        command = COMMANDS_BY_LETTER.get(text.take())
        return None if command is None else self._run(command, text)

    def from_network(self) -> Steps:
        """Answer packets that have come, and execute them."""
        for packet in self.network.received():
            yield from self.network.acknowledge(packet)
            if not packet.is_good:
                continue
            if is_signal(packet):
                if packet.data == NAK:
                    self.terminal.message(b"NAK %d" % packet.origin)
                continue
            self.network.remember(packet)
            data = packet.data.decode("latin-1")
            if data[:1] and data[0] in SEPARATORS:
                self.terminal.message(packet.data[1:])
            else:
                yield from self._command_from_network(Text(data.partition(" ")[0]))

    def takes(self, packets: Sequence[Item]) -> bool:
        """Execute a packet to everybody, if that takes no time and needs no terminal: as ``from_network``
        would, without the main loop; return whether it has."""
        quick, network = _quick(packets[0]), self.network
        if quick is None or len(packets) != 1 or not network.decoder.is_whole:
            return False
        if quick.is_remembered:
            network.last_sender = None
        if quick.velocity is not None:  # it prints nothing, and most packets to all are of it
            self.moves.velocity(quick.velocity)
        elif quick.run:
            self.terminal.is_muted = True
            quick.run(self, quick.rest)
            self.terminal.is_muted = False
        return True

    def _command_from_network(self, text: Text) -> Steps:
        """Execute a packet's data. It answers no queries, and opens no screens."""
        if text.peek() and text.peek() in "+-":
            self.motion.pulse(text.take() == "-")
            return
        command = COMMANDS_BY_LETTER.get(text.take())
        if command is None:
            return
        mode = self.terminal.mode
        self.terminal.is_muted = True
        yield from command.run(self, text) or ()
        self.terminal.is_muted = False
        self.terminal.mode = mode

    def _run(self, command: Command, text: Text) -> Steps:
        yield from command.run(self, text) or ()
        if self.session.is_debug:
            self.terminal.println([f"{(self.now() - self.terminal.line_began_ns) // 1000} us"])

    def _in_mode(self, mode: Callable[[Text], Steps | None], text: Text) -> Steps | None:
        """Execute a line of the configure screen or of a program mode."""
        if text.takes("xX"):
            self.terminal.mode = None
            return None
        return mode(text)

    # ---- commands of several parts ----

    def velocity(self, text: Text) -> None:
        """Set the velocity; ``vd`` shows the speed of now (decision: RPM, TAB, period)."""
        if text.takes("dD"):
            shown = [f"{int(self.motion.get('speed_rpm'))}\t{int(self.motion.get('period_us'))}"]
            self.terminal.println(shown)
            return
        self.moves.velocity(text.rest())

    def debug(self, text: Text) -> None:
        self.session.is_debug = not self.session.is_debug

    def toggle_gap(self, text: Text) -> None:
        self.session.is_gap_on = not self.session.is_gap_on
        self.motion.gap(self.session.is_gap_on)

    def show(self, text: Text) -> None:
        """Execute ``cc`` and ``cf``, which show."""
        if text.takes("cC"):
            self.system.show_configuration()
        elif text.takes("fF"):
            self.terminal.println(self.session.lines())

    def queue_command(self, text: Text) -> Steps | None:
        """Execute ``q`` and what may follow it."""
        if not text.peek():
            self.terminal.println(self.queue.lines())
        elif text.is_digit():
            self.queue.edit(text)
        elif text.takes("sS"):
            self.memory.eeprom.queue = self.queue.entries()
            return self.memory.save()
        elif text.takes("rR"):
            self.queue.restore(self.memory.eeprom.queue)
        elif text.takes("cC"):
            self.queue.clear()
        elif text.takes("pP"):
            self.terminal.println(self.queue.lines())
            self.terminal.mode = self.queue.edit
        return None

    def xref(self, text: Text) -> None:
        """Execute ``x`` and what may follow it."""
        if text.takes("dD"):
            self.terminal.println(self.queue.xref_lines())
        elif text.takes("pP"):
            self.terminal.mode = self._edit_xref
        elif text.takes("lL"):
            self.moves.loop_array(text)
        elif text.takes("mM"):
            self.moves.one_shot(text)
        else:
            self.moves.recall(text)

    def _edit_xref(self, text: Text) -> None:
        if self.queue.edit_xref(text):
            self.terminal.println(self.queue.xref_lines())


def _quick_command(letters: str, about: str, run: Callable[[CommandLine, Text], None]) -> Command:
    return Command(letters, about, run, lambda line, rest: run(line, Text(rest)))


def _bare_command(letters: str, about: str, run: Callable[[CommandLine], None]) -> Command:
    """Make a quick command that reads nothing behind its letter."""
    return Command(letters, about, lambda line, text: run(line), lambda line, rest: run(line))


COMMANDS = (
    _quick_command("mM", "motion command", lambda line, text: line.moves.queued(text)),
    _quick_command("aA", "acceleration of the session", lambda line, text: line.moves.acceleration(text)),
    _quick_command("dD", "deceleration of the session", lambda line, text: line.moves.deceleration(text)),
    Command("vV", "velocity of the session, vd: of now", CommandLine.velocity),
    _quick_command("lL", "loops; alone: end in a controlled way", lambda line, text: line.moves.loop(text)),
    Command("xX", "run an entry or a one-shot at once; xRef array", CommandLine.xref),
    _bare_command("S", "stop at once", lambda line: line.motion.stop(None)),
    _bare_command("s", "stop with the session's deceleration", lambda line: line.moves.stop_gracefully()),
    _bare_command("N", "next command, at once", lambda line: line.motion.next(False)),
    _bare_command("n", "next command, with this one's deceleration", lambda line: line.motion.next(True)),
    _bare_command("y", "release the sync", lambda line: line.motion.release_sync()),
    Command("qQ", "queue: list, edit, save, restore, clear, program", CommandLine.queue_command),
    _bare_command("zZ", "undo the last change of the queue", lambda line: line.queue.undo()),
    Command("gG", "GAP testing on or off", CommandLine.toggle_gap),
    Command("cC", "cc: configuration, cf: session", CommandLine.show),
    Command("bB", "debug on or off", CommandLine.debug),
    Command("$", "system commands", lambda line, text: line.system.run(text)),
)
COMMANDS_BY_LETTER = {letter: command for command in COMMANDS for letter in command.letters}


class _Quick(NamedTuple):
    """Packet to everybody that takes no time and needs no terminal, as every node reads it."""

    is_remembered: bool = False
    """True if replies go to the sender of this packet from now on."""
    run: Callable[[CommandLine, str], object] | None = None
    rest: str = ""
    """Rest of its line behind the command's letter."""
    velocity: str | None = None
    """Text behind ``v``, which is set instead of ``run``."""


@lru_cache(maxsize=4)
def _quick(packet: Item) -> _Quick | None:
    """Read a packet; None: it is for one, or needs the terminal, or time. Cached, because all nodes read the
    same."""
    if not isinstance(packet, Packet) or packet.destination != BROADCAST or not packet.crc:
        return None  # a NUL behind one without CRC would be idle
    if not packet.is_good:
        return _Quick()
    text = Text(packet.data.decode("latin-1").partition(" ")[0])
    if packet.data == NAK or packet.data[:1].decode("latin-1") in (*SEPARATORS, "+", "-"):
        return None
    command = COMMANDS_BY_LETTER.get(text.take())
    if command is None:
        return _Quick(is_remembered=not is_signal(packet))
    if command.letters == "vV":
        said = text.rest()
        return _Quick(True, velocity=None if said[:1] in ("d", "D") else said)
    return _Quick(True, command.quick, text.rest()) if command.quick else None
