"""The SAC's program: power-up, command line, memory and system commands. The motion itself is the core's.

Sources: the SAC user manual, Appendix C and the chapters Command Detail, Configure and System Commands. Where
it leaves something open, ``README.md`` of this folder lists what was decided.
"""

from collections.abc import Callable, Generator, Iterable
from dataclasses import replace
from typing import Any, NamedTuple

from device_profiles.sac import screens
from device_profiles.sac.eeprom import Eeprom, EepromError
from device_profiles.sac.line import Attributes, Text
from device_profiles.sac.moves import Moves
from device_profiles.sac.network import BROADCAST, DC1, DC2, NAK, SEPARATORS, Network, is_signal
from device_profiles.sac.parameters import FACTORY_BAUD, SOFTWARE_BAUD_LIMIT, Parameters, change
from device_profiles.sac.queue_memory import QueueMemory
from device_profiles.sac.session import Session
from device_profiles.sac.terminal import Terminal
from hil.vocab.firmware import MAIN, NETWORK, Board, ByteAvailable, Commit, CoreEvent, Delay, Main, Request
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.wire.packet import UNUSABLE_ADDRESSES

VERSION = "1.0"
COLD_START_NS = 1000 * NS_PER_MS
"""From the version to the first prompt; a byte in it restores the factory's settings (manual, bail-out)."""
MEMORY, ASIDE = "eeprom", "eeprom_damaged"
"""Sections of the board's memory: the EEPROM, and what could not be read when it was one."""

Steps = Generator[Request, Any, None]


class Command(NamedTuple):
    """What a line's first letter starts; ``run`` gets the rest of the line."""

    letters: str
    about: str
    run: Callable[["Sac", Text], Steps | None]


class Sac:
    """One power-up of the firmware."""

    def __init__(self, board: Board) -> None:
        if board.motion is None or board.network is None:
            raise TypeError("a SAC needs a board that makes step pulses and has two UARTs")
        self.motion = self._motion = board.motion
        self._uarts = {MAIN: board.uart, NETWORK: board.network}
        self._nvm = board.nvm
        self._note = board.note
        self._terminal = Terminal(board.uart, self._now)
        self._eeprom = Eeprom()
        self._session = Session(self._eeprom.parameters)
        self._network = Network(self._session)
        self._bauds = (FACTORY_BAUD, FACTORY_BAUD)
        self.queue = QueueMemory(board.motion, self._session)
        self.moves = Moves(board.motion, self._session, self.queue)
        self._mode: Callable[[Text], Steps | None] | None = None
        self.is_started = False
        """The cold start is over."""
        self._note_estop()

    def main(self) -> Main:
        yield from self._load()
        is_rst_low = self._is_rst_low()
        self._set_ports(Parameters() if is_rst_low else self._eeprom.parameters)
        if (yield from self._wants_factory()) or is_rst_low:
            self._eeprom = Eeprom()
            yield from self._save()
        yield from self.reset()
        self.queue.seed(self._eeprom.queue)
        if self._eeprom.parameters.autorun > 0:
            self._motion.loop_start(1)
            self._motion.loop_finish(self._eeprom.parameters.autorun)
        self.is_started = True
        while True:
            self._terminal.prompt()
            line = yield from self._terminal.read_line(self._single_pulse, self._from_network)
            yield from self._execute(line) or ()

    def interrupt(self, event: CoreEvent) -> None:
        """A command begins or ends, which soft_ops tells: a packet to all, and a byte to the terminal. Or
        Estop has changed."""
        if event.kind == "estop":
            self._note_estop()
            return
        begins = event.kind == "command_begun"
        self._terminal.uart.write(DC1 if begins else DC2)
        self._network.operation(begins)

    def _note_estop(self) -> None:
        """Its falling edge has stopped all; the board obeys as ever while it stays low."""
        is_low = self._motion.get("pin_estop") == 0
        self._note(
            "Estop", "Estop is low: it has stopped all when it fell, and holds nothing" if is_low else None
        )

    @property
    def parameters(self) -> Parameters:
        """Those in force."""
        return self._session.parameters

    def _now(self) -> SimTimeNs:
        return SimTimeNs(int(self._motion.get("at_ns")))

    # ---- power-up and reset ----

    def _wants_factory(self) -> Generator[Request, Any, bool]:
        """The cold start's second. What the network sends in it is lost."""
        wants_it = False
        self._terminal.println([f"SAC {VERSION}"])
        end_ns = self._now() + COLD_START_NS
        while (left_ns := end_ns - self._now()) > 0:
            if (yield ByteAvailable(left_ns)):
                wants_it |= bool(self._terminal.uart.read_all())
                list(self._network.received())
        return wants_it or self._is_rst_low()

    def _is_rst_low(self) -> bool:
        return self._motion.get("pin_rst") == 0

    def reset(self) -> Steps:
        """What a cold start and ``$R`` do: the EEPROM's parameters come into force. The queue stays."""
        parameters = self._eeprom.copy().parameters
        self._session.restart(parameters)
        self._motion.setup(parameters.setup())
        self._motion.gap(self._session.is_gap_on)
        self._motion.encoder_mode(self._session.is_throttle)
        self._motion.report(self._session.is_soft_ops_on)
        is_lost = parameters.device_id in (BROADCAST, *UNUSABLE_ADDRESSES)
        self._note("id", f"d_id is {parameters.device_id}: no packet reaches it" if is_lost else None)
        is_too_fast = parameters.software_baud > SOFTWARE_BAUD_LIMIT
        self._note("sw", "the software port is above 38400 baud" if is_too_fast else None)
        if parameters.bauds() != self._bauds:
            slowest = min(uart.baud or FACTORY_BAUD for uart in self._uarts.values())
            yield Delay(NS_PER_S * 10 * 66 // slowest)  # a full transmit buffer and two characters on the way
        self._set_ports(parameters)

    def _set_ports(self, parameters: Parameters) -> None:
        """Speeds, and which port is the terminal. E at 1 swaps them; if nothing is at the other one, a hard
        reset helps: RST low at a cold start (manual, network)."""
        self._bauds = parameters.bauds()
        for uart, baud in zip(self._uarts.values(), self._bauds, strict=True):
            # The factory's speed is the line's own, which the configuration may have set to another.
            uart.set_baud(None if baud == FACTORY_BAUD else baud)
        is_swapped = bool(parameters.is_network_swapped)
        self._terminal.uart = self._uarts[NETWORK if is_swapped else MAIN]
        self._terminal.uart.wake_on(None)
        self._network.use(self._uarts[MAIN if is_swapped else NETWORK])
        swapped = "E is 1: packets here, the terminal is at the network port; else pull RST low and reset"
        self._note("terminal", swapped if is_swapped else None)

    # ---- memory ----

    def _load(self) -> Steps:
        stored = self._nvm.get(MEMORY)
        if stored is None:
            return
        try:
            self._eeprom = Eeprom.unpacked(stored)
        except EepromError as error:
            aside = next(name for n in range(1, 1000) if (name := f"{ASIDE}-{n}") not in self._nvm)
            self._note("eeprom", f"EEPROM: {error}; it was kept as {aside}, the factory's settings hold")
            if (yield Commit(aside, stored)):
                yield from self._save()

    def _save(self) -> Steps:
        """Make the EEPROM durable. Where that fails the old content is what a read-back shows."""
        if not (yield Commit(MEMORY, self._eeprom.packed())):
            stored = self._nvm.get(MEMORY)
            self._eeprom = Eeprom.unpacked(stored) if stored else Eeprom()

    # ---- the command line ----

    def _single_pulse(self, byte: int) -> bool:
        """``+`` and ``-`` need no line end (manual, communications)."""
        if byte not in b"+-" or self._mode is not None:
            return False
        self._motion.pulse(byte == ord("-"))
        return True

    def _execute(self, line: str) -> Steps | None:
        """A line of the terminal: the network's if it begins with an address, else up to its first blank."""
        text = Text(line.partition(" ")[0])
        if self._mode is not None:
            return self._in_mode(text)
        if self._network.typed(line):
            return None
        command = COMMANDS_BY_LETTER.get(text.take())
        return None if command is None else self._run(command, text)

    def _from_network(self) -> Steps:
        """Answer what has come and do what it says."""
        for packet in self._network.received():
            yield from self._network.acknowledge(packet)
            if not packet.is_good:
                continue
            if is_signal(packet):
                if packet.data == NAK:
                    self._terminal.message(b"NAK %d" % packet.origin)
                continue
            self._network.remember(packet)
            data = packet.data.decode("latin-1")
            if data[:1] and data[0] in SEPARATORS:
                self._terminal.message(packet.data[1:])
            else:
                yield from self._command_from_network(Text(data.partition(" ")[0]))

    def _command_from_network(self, text: Text) -> Steps:
        """What a packet's data has the unit do. It answers no queries, and opens no screens."""
        if text.peek() and text.peek() in "+-":
            self._motion.pulse(text.take() == "-")
            return
        command = COMMANDS_BY_LETTER.get(text.take())
        if command is None:
            return
        mode = self._mode
        self._terminal.is_muted = True
        yield from command.run(self, text) or ()
        self._terminal.is_muted = False
        self._mode = mode

    def _run(self, command: Command, text: Text) -> Steps:
        yield from command.run(self, text) or ()
        if self._session.is_debug:
            self._terminal.println([f"{(self._now() - self._terminal.line_began_ns) // 1000} us"])

    def _in_mode(self, text: Text) -> Steps | None:
        """A line of the configure screen or of a program mode."""
        if text.takes("xX"):
            self._mode = None
            return None
        return self._mode(text) if self._mode else None

    # ---- line commands ----

    def velocity(self, text: Text) -> None:
        """``vd`` shows the speed of now (decision: RPM, TAB, period); all else sets it."""
        if text.takes("dD"):
            shown = [f"{int(self._motion.get('speed_rpm'))}\t{int(self._motion.get('period_us'))}"]
            self._terminal.println(shown)
            return
        self.moves.velocity(text)

    def debug(self, text: Text) -> None:
        self._session.is_debug = not self._session.is_debug

    def show(self, text: Text) -> None:
        """``cc`` and ``cf``."""
        if text.takes("cC"):
            self._show_configuration()
        elif text.takes("fF"):
            self._terminal.println(self._session.lines())

    def _show_configuration(self) -> None:
        self._terminal.println(screens.configuration(self._eeprom.parameters))

    def queue_command(self, text: Text) -> Steps | None:
        """``q`` and what may follow it."""
        if not text.peek():
            self._terminal.println(self.queue.lines())
        elif text.is_digit():
            self.queue.edit(text)
        elif text.takes("sS"):
            self._eeprom.queue = self.queue.entries()
            return self._save()
        elif text.takes("rR"):
            self.queue.restore(self._eeprom.queue)
        elif text.takes("cC"):
            self.queue.clear()
        elif text.takes("pP"):
            self._terminal.println(self.queue.lines())
            self._mode = self.queue.edit
        return None

    def undo(self, text: Text) -> None:
        self.queue.undo()

    def xref(self, text: Text) -> None:
        """``x`` and what may follow it."""
        if text.takes("dD"):
            self._terminal.println(self.queue.xref_lines())
        elif text.takes("pP"):
            self._mode = self._edit_xref
        elif text.takes("lL"):
            self.moves.loop_array(text)
        elif text.takes("mM"):
            self.moves.one_shot(text)
        else:
            self.moves.recall(text)

    def _edit_xref(self, text: Text) -> None:
        if self.queue.edit_xref(text):
            self._terminal.println(self.queue.xref_lines())

    # ---- system commands ----

    def system(self, text: Text) -> Steps | None:
        """``$``: any of them ends all activity first; letters as they are written here."""
        self._motion.stop(None)
        session = self._session
        match text.take():
            case "C":
                return self._configure(text)
            case "E":
                self._show_eeprom()
            case "R":
                return self.reset()
            case "F":
                self._set_pulses(False)
            case "P":
                self._set_pulses(True)
            case "U":
                self._set_pulses(not session.default.is_pulses)
            case "H":
                session.is_crc_on = text.number() != 0
            case "K":
                session.is_ack_on = text.number() != 0
            case "L" if (number := text.number()) is not None:
                session.say(Attributes(is_linear=number != 0))
            case "O" if (number := text.number()) is not None:
                session.is_soft_ops_on = number != 0
                self._motion.report(session.is_soft_ops_on)
            case "n":
                session.is_throttle = not session.is_throttle
                self._motion.encoder_mode(session.is_throttle)
        return None

    def _set_pulses(self, is_pulses: bool) -> None:
        self._session.default = replace(self._session.default, is_pulses=is_pulses)

    def _show_eeprom(self) -> None:
        lines: Iterable[str] = screens.configuration(self._eeprom.parameters)
        if self._session.is_debug:
            lines = screens.dump(self._nvm.get(MEMORY, self._eeprom.packed()))
        self._terminal.println(lines)

    def _configure(self, text: Text) -> Steps | None:
        """``$C`` with a letter and a value sets it. Alone: the screen, drawn again after each edit."""
        if text.peek():
            return self._save() if change(self._eeprom.parameters, text) else None
        self._show_configuration()
        self._mode = self._edit_configuration
        return None

    def _edit_configuration(self, text: Text) -> Steps:
        if change(self._eeprom.parameters, text):
            yield from self._save()
            self._show_configuration()


COMMANDS = (
    Command("mM", "motion command", lambda sac, text: sac.moves.queued(text)),
    Command("aA", "acceleration of the session", lambda sac, text: sac.moves.acceleration(text)),
    Command("dD", "deceleration of the session", lambda sac, text: sac.moves.deceleration(text)),
    Command("vV", "velocity of the session, vd: of now", Sac.velocity),
    Command("lL", "loops; alone: end with grace", lambda sac, text: sac.moves.loop(text)),
    Command("xX", "run an entry or a one-shot at once; xRef array", Sac.xref),
    Command("S", "stop at once", lambda sac, text: sac.moves.stop_at_once(text)),
    Command("s", "stop with the session's deceleration", lambda sac, text: sac.moves.stop_gracefully(text)),
    Command("N", "next command, at once", lambda sac, text: sac.moves.next_at_once(text)),
    Command(
        "n", "next command, with this one's deceleration", lambda sac, text: sac.moves.next_gracefully(text)
    ),
    Command("y", "release the sync", lambda sac, text: sac.moves.release(text)),
    Command("qQ", "queue: list, edit, save, restore, clear, program", Sac.queue_command),
    Command("zZ", "undo the last change of the queue", Sac.undo),
    Command("gG", "GAP testing on or off", lambda sac, text: sac.moves.toggle_gap(text)),
    Command("cC", "cc: configuration, cf: session", Sac.show),
    Command("bB", "debug on or off", Sac.debug),
    Command("$", "system commands", Sac.system),
)
COMMANDS_BY_LETTER = {letter: command for command in COMMANDS for letter in command.letters}
