"""Program of the SAC: power-up, reset and the main loop. The motion itself is the core's.

Source: the SAC user manual. Where it leaves something open, ``README.md`` of this folder lists what was
decided.
"""

from collections.abc import Generator
from typing import Any

from device_profiles.sac.command_line import CommandLine
from device_profiles.sac.eeprom import Eeprom, Memory
from device_profiles.sac.network import BROADCAST, DC1, DC2, Network
from device_profiles.sac.packet import UNUSABLE_ADDRESSES
from device_profiles.sac.parameters import FACTORY_BAUD, SOFTWARE_BAUD_LIMIT, Parameters
from device_profiles.sac.session import Session
from device_profiles.sac.system_commands import SystemCommands
from device_profiles.sac.terminal import Steps, Terminal
from hil.vocab.firmware import MAIN, NETWORK, Board, ByteAvailable, CoreEvent, Delay, Main, Request
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

FIRMWARE_VERSION = "1.0"
COLD_START_NS = 1000 * NS_PER_MS
"""Time from the version to the first prompt; a byte in it restores the factory's settings (manual,
bail-out)."""


class Sac:
    """One power-up of the firmware."""

    def __init__(self, board: Board) -> None:
        if not board.motions or NETWORK not in board.uarts:
            raise TypeError("a SAC needs a board that makes step pulses and has two UARTs")
        self.motion = board.motion
        self._uarts = board.uarts
        self._bauds = (FACTORY_BAUD, FACTORY_BAUD)
        self._note = board.note
        self._memory = Memory(board.nvm, board.note)
        self._session = Session(self._memory.eeprom.parameters)
        self._terminal = Terminal(board.uart, self._now)
        self._network = Network(self._session)
        system = SystemCommands(board.motion, self._session, self._terminal, self._memory, self.reset)
        self._line = CommandLine(
            board.motion, self._session, self._terminal, self._network, self._memory, system, self._now
        )
        self.queue, self.moves = self._line.queue, self._line.moves
        self.is_started = False
        """True once the cold start is over."""
        self._note_estop()

    def main(self) -> Main:
        yield from self._memory.load()
        is_rst_low = self._is_rst_low()
        self._set_ports(Parameters() if is_rst_low else self._memory.eeprom.parameters, None)
        if (yield from self._wants_factory()) or is_rst_low:
            self._memory.eeprom = Eeprom()
            yield from self._memory.save()
        yield from self.reset()
        self.queue.seed(self._memory.eeprom.queue)
        if self._memory.eeprom.parameters.autorun > 0:
            self.motion.loop_start(1)
            self.motion.loop_finish(self._memory.eeprom.parameters.autorun)
        self.is_started = True
        while True:
            self._terminal.prompt()
            line = yield from self._terminal.read_line(
                self._line.single_pulse, self._line.from_network, self._line.takes
            )
            yield from self._line.execute(line) or ()

    def interrupt(self, event: CoreEvent) -> None:
        """Tell that a command begins or ends, as soft_ops does: a packet to all, and a byte to the terminal.
        Or note a change of Estop."""
        if event.kind == "estop":
            self._note_estop()
            return
        begins = event.kind == "command_begun"
        self._terminal.uart.write(DC1 if begins else DC2)
        self._network.operation(begins)

    def _note_estop(self) -> None:
        """Note Estop: its falling edge has stopped all; the board obeys as before while it stays low."""
        is_low = self.motion.get("pin_estop") == 0
        self._note(
            "Estop", "Estop is low: it has stopped all when it fell, and holds nothing" if is_low else None
        )

    @property
    def parameters(self) -> Parameters:
        """The parameters in force."""
        return self._session.parameters

    def _now(self) -> SimTimeNs:
        return SimTimeNs(int(self.motion.get("at_ns")))

    # ---- power-up and reset ----

    def _wants_factory(self) -> Generator[Request, Any, bool]:
        """Wait for the cold start's second; answers whether a byte or RST wants the factory's settings. Bytes
        from the network in that second are lost."""
        wants_it = False
        self._terminal.println([f"SAC {FIRMWARE_VERSION}"])
        end_ns = self._now() + COLD_START_NS
        while (left_ns := end_ns - self._now()) > 0:
            if (yield ByteAvailable(left_ns)):
                wants_it |= bool(self._terminal.uart.read_all())
                list(self._network.received())
        return wants_it or self._is_rst_low()

    def _is_rst_low(self) -> bool:
        return self.motion.get("pin_rst") == 0

    def reset(self) -> Steps:
        """Put the EEPROM's parameters into force, at a cold start and by ``$R``. The queue stays."""
        parameters = self._memory.eeprom.copy().parameters
        self._session.restart(parameters)
        self.motion.setup(parameters.setup())
        self.motion.gap(self._session.is_gap_on)
        self.motion.encoder_mode(self._session.is_throttle)
        self.motion.report(self._session.is_soft_ops_on)
        is_lost = parameters.device_id in (BROADCAST, *UNUSABLE_ADDRESSES)
        self._note("id", f"d_id is {parameters.device_id}: no packet reaches it" if is_lost else None)
        is_too_fast = parameters.software_baud > SOFTWARE_BAUD_LIMIT
        self._note("sw", "the software port is above 38400 baud" if is_too_fast else None)
        if parameters.bauds() != self._bauds:
            slowest = min(uart.baud or FACTORY_BAUD for uart in self._uarts.values())
            yield Delay(NS_PER_S * 10 * 66 // slowest)  # a full transmit buffer and two characters on the way
        self._set_ports(parameters, parameters.device_id)

    def _set_ports(self, parameters: Parameters, address: int | None) -> None:
        """Set speeds, and the ports of the terminal and of packets, there with an address or none yet. E at 1
        swaps the ports; if nothing is at the other one, a hard reset helps: RST low at a cold start (manual,
        network)."""
        self._bauds = parameters.bauds()
        for uart, baud in zip(self._uarts.values(), self._bauds, strict=True):
            # The factory's speed is the line's own, which the configuration may have set to another.
            uart.set_baud(None if baud == FACTORY_BAUD else baud)
        is_swapped = bool(parameters.is_network_swapped)
        self._terminal.uart = self._uarts[NETWORK if is_swapped else MAIN]
        self._terminal.uart.wake_on(None)
        self._network.use(self._uarts[MAIN if is_swapped else NETWORK], address)
        swapped = "E is 1: packets here, the terminal is at the network port; else pull RST low and reset"
        self._note("terminal", swapped if is_swapped else None)
