"""A group: the devices that share one simulated time, advanced with their axes.

The core runs the axes up to the group's horizon, the earliest time at which a firmware has to run; the
firmware runs at exactly that time; and so on. This loop is the same in real and in virtual time.
"""

from hil.core import Core
from hil.session.device import Device
from hil.session.inputs import Input
from hil.vocab.time import SimTimeNs


class Group:
    """Devices in the order of their index, which decides ties. The caller owns the group in the core."""

    def __init__(self, core: Core, group: int) -> None:
        self._core = core
        self._native = core.native
        self.id = group
        self.devices: list[Device] = []

    @property
    def now_ns(self) -> SimTimeNs:
        """The time the group has reached."""
        return SimTimeNs(self._native.now(self.id))

    def advance(self, until_ns: SimTimeNs) -> None:
        """Run axes and firmwares up to and at ``until_ns``; never back."""
        while True:
            horizon_ns = min(device.due_ns for device in self.devices)
            self._native.set_horizon(self.id, horizon_ns)
            now_ns = SimTimeNs(self._native.advance(self.id, until_ns))
            self._interrupts()
            if now_ns >= horizon_ns:
                for device in self.devices:
                    if device.due_ns <= now_ns:
                        device.step(now_ns)
            elif now_ns >= until_ns:
                return

    def apply(self, device: Device, given: Input) -> None:
        """An input takes effect now, and the firmware runs on it."""
        now_ns = self.now_ns
        device.apply(given, now_ns)
        device.step(now_ns)

    def _interrupts(self) -> None:
        for event in self._core.take_events(self.id):
            for device in self.devices:
                if device.axis.id == event.axis:
                    device.interrupt(event)
        if self._native.failed(self.id):
            for device in self.devices:
                if not device.failed:
                    device.fail("the ring of its interrupts' events overflowed")
