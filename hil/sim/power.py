"""Power of a device: what starts its firmware, and what stops it."""

from collections.abc import Callable

from hil.firmware.runtime import FirmwareStuck
from hil.sim.firmware_guard import FirmwareHung, Guard, StopLogged, place_of
from hil.sim.hardware import DeviceSpec, Hardware
from hil.sim.inputs import Stopped
from hil.sim.setpoints import Setpoints
from hil.sim.sketch import Sketch
from hil.vocab.firmware import Commit
from hil.vocab.time import SimTimeNs


class Power:
    """Power of a device, and the sketch that runs on it until something stops it.

    ``commit``: as ``Sketch`` takes it. ``on_stopped``: called with the time when the firmware stops for a
    reason that simulated time does not have; ``on_failed`` comes next. ``on_failed``: called when the device
    has stopped, and ``failed`` says why.
    """

    def __init__(
        self,
        spec: DeviceSpec,
        hardware: Hardware,
        setpoints: Setpoints,
        guard: Guard,
        *,
        commit: Callable[[Commit], None],
        on_stopped: Callable[[SimTimeNs, Stopped], None],
        on_failed: Callable[[], None],
    ) -> None:
        self.failed: str | None = None
        """Reason for which the device has stopped."""
        self.ups = 1
        """Number of power-ups, the start included."""
        self.listeners: list[Callable[[bool], None]] = []
        """Called when the power has gone (False), and with each power-up but the first (True)."""
        self._why_not: str | None = None
        self._hardware, self._interfaces, self._setpoints = hardware, hardware.interfaces, setpoints
        self._on_stopped, self._on_failed = on_stopped, on_failed
        self.sketch = Sketch(spec, hardware, guard, commit, self._raised)

    @property
    def is_there(self) -> bool:
        """True if no fault takes the power; without it no reset starts the firmware."""
        return self._why_not is None

    def switch(self, why_not: str | None, now_ns: SimTimeNs) -> None:
        """Take the power away, with the reason, or give it back (None). Without power the device does
        nothing, nothing is heard of it, and no reset starts it; its ``step`` comes next."""
        was_off, self._why_not = self._why_not, why_not
        if why_not:
            self.failed = why_not
            if not was_off:
                self.sketch.runtime.close()
                self._hardware.cut_axes()
                self._tell(False)
        elif was_off:
            self._interfaces.set_time(now_ns)
            self._up()

    def reset(self) -> None:
        """Start the firmware again, if there is power."""
        if self.is_there:
            self._up()

    def reset_processors(self) -> None:
        """Start the firmware again as the processor's RESET pin does, if there is power."""
        if self.is_there:
            self._up(self._hardware.reset_processors)

    def _up(self, power_up: Callable[[], None] | None = None) -> None:
        self.sketch.runtime.close()
        self.failed = None
        self.ups += 1
        self._setpoints.end()
        (power_up or self._hardware.power_up)()
        self.sketch.power_up()
        self._tell(True)

    def _tell(self, is_there: bool) -> None:
        for listener in self.listeners:
            listener(is_there)

    def close(self) -> None:
        """Stop the firmware forever; the axis goes with its group."""
        self.failed = "it was taken out"
        self.sketch.close()

    def fail(self, reason: str) -> None:
        """Stop the device for good; only a reset brings it back."""
        self._interfaces.cut()
        self._interfaces.end()
        self.failed = reason
        self.sketch.runtime.close()
        self._hardware.stop_axes()
        self._on_failed()

    def _raised(self, error: BaseException) -> None:
        """Stop the device because its firmware did not come through its turn."""
        if isinstance(error, StopLogged):
            self._stop(error.stopped)
            return
        place = "" if isinstance(error, FirmwareStuck) else place_of(error)  # its text has it
        reason = f"{type(error).__name__}: {error}{place}"
        # These depend on the process: a replay has to be told of them.
        if isinstance(error, FirmwareHung | MemoryError | RecursionError):
            self._stop(Stopped(self.sketch.turns, reason, self._interfaces.cut()))
        else:
            self.fail(reason)

    def _stop(self, stopped: Stopped) -> None:
        """Stop as ``fail``, where nobody can tell how far the firmware had come: nothing is left of its turn
        but what it has sent, and board and axis stand as after power-up."""
        self._on_stopped(self._interfaces.now_ns, stopped)
        self.sketch.runtime.close()
        self._setpoints.end()
        self._hardware.power_up_axes()
        self._interfaces.halt(stopped.words)
        self._interfaces.end()
        self.failed = stopped.reason
        self._on_failed()
