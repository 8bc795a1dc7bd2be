"""A running firmware: all code of a profile is called from here, under guard."""

from collections.abc import Callable
from typing import TypeVar

from hil.firmware.runtime import Runtime
from hil.sim.firmware_guard import NOTHING, UNGUARDED, Guard
from hil.sim.flight import Flight
from hil.sim.hardware import DeviceSpec, Hardware
from hil.vocab.firmware import Commit, Main
from hil.vocab.time import FOREVER, SimTimeNs

Result = TypeVar("Result")


class Sketch:
    """Firmware of a board, ``hil.sim.firmware_guard.Guarded``. Its exceptions go to ``on_raised``."""

    def __init__(
        self,
        spec: DeviceSpec,
        hardware: Hardware,
        guard: Guard,
        commit: Callable[[Commit], None],
        on_raised: Callable[[BaseException], None],
    ) -> None:
        self.name = spec.name
        self.turns = 0
        """Number of turns so far: all that it does by itself."""
        self._make = spec.firmware
        self._hardware, self._board = hardware, hardware.board
        self._interfaces = hardware.interfaces
        self._guard = guard
        self._commit = commit
        self._on_raised = on_raised
        self.power_up()

    def power_up(self) -> None:
        """Start the firmware again with the next turn."""
        self.is_on = False
        """True once the first turn after this has made the firmware."""
        interfaces = self._interfaces
        self.runtime = Runtime(self._main(), interfaces.has_input, self._commit, interfaces.print_returns)
        self.runtime.due_ns = interfaces.now_ns

    def _main(self) -> Main:
        """Make the main program in the first turn: one that cannot be made fails as one that runs does."""
        self._hardware.started_ns = self._interfaces.now_ns
        self.firmware = self._make(self._board)
        self.is_on = True
        yield from self.firmware.main()

    @property
    def now_ns(self) -> SimTimeNs:
        return self._interfaces.now_ns

    @property
    def is_busy(self) -> bool:
        """True while the main program is in a routine of its own, and takes no commands."""
        return self.is_on and bool(getattr(self.firmware, "is_busy", False))

    @property
    def lacks(self) -> tuple[str, str] | None:
        """Thing that the firmware lacks to hold an angle, and the verb that makes it; None: nothing."""
        return getattr(self.firmware, "lacks", None) if self.is_on else None

    @property
    def is_ready(self) -> bool:
        """True if the main program has started and takes commands."""
        if not self.is_on or getattr(self.firmware, "is_busy", False):
            return False
        return bool(getattr(self.firmware, "is_started", True))

    def turn(
        self, work: Callable[..., Result], *given: object, passes: tuple[type[Exception], ...] = ()
    ) -> Result | None:
        """Call what runs firmware; None if it did not come through. ``passes``: errors for the caller."""
        self.turns += 1
        try:
            with NOTHING if self._guard is UNGUARDED else self._guard(self):
                return work(*given)
        # A firmware may raise SystemExit too, and ends nobody but its own device.
        except BaseException as error:
            if isinstance(error, (KeyboardInterrupt, *passes)):
                raise
            self._on_raised(error)
            return None

    def offer(self, now_ns: SimTimeNs, offered: tuple[int, Flight]) -> bool:
        """Offer packets, in a turn, to a reader beside the main program; if it declines, the program gets
        their bytes. ``offered``: the number of the UART, and what came there.

        Return true if the turn is over with that, and nothing was written: the firmware's state is as before.
        """
        self.turns += 1
        runtime, interfaces, guard = self.runtime, self._interfaces, self._guard
        interfaces.now_ns = now_ns
        try:
            with NOTHING if guard is UNGUARDED else guard(self):
                if runtime.takes and runtime.takes(offered[1].packets or ()):
                    if not interfaces.written:
                        runtime.polls_from_ns, runtime.due_ns = now_ns, FOREVER
                        return True
                    interfaces.set_time(now_ns)
                    runtime.go_on_waiting(now_ns, interfaces.print_returns(now_ns))
                else:
                    with guard.aside():
                        interfaces.take_in(now_ns, runtime.polls_from_ns, *offered)
                    runtime.resume(now_ns)
        # A firmware may raise SystemExit too, and ends nobody but its own device.
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            interfaces.set_time(now_ns)
            self._on_raised(error)
        return False

    def close(self) -> None:
        """Stop the firmware forever."""
        try:
            with self._guard(self):
                self.runtime.close()
        except KeyboardInterrupt:
            raise
        except BaseException:  # the program is dropped anyway
            return
