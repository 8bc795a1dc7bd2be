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

    def __enter__(self) -> None:
        """Own it, in real time: for as long as the block lasts the core's thread leaves it alone."""
        self._native.acquire(self.id)

    def __exit__(self, *_: object) -> None:
        self._native.release(self.id)

    @property
    def now_ns(self) -> SimTimeNs:
        """The time the group has reached."""
        return SimTimeNs(self._native.now(self.id))

    @property
    def due_ns(self) -> SimTimeNs:
        """The earliest time at which a firmware has to run."""
        devices = self.devices
        return devices[0].due_ns if len(devices) == 1 else min(device.due_ns for device in devices)

    def advance(self, until_ns: SimTimeNs) -> None:
        """Run axes and firmwares up to and at ``until_ns``; never back."""
        while True:
            horizon_ns = self.due_ns
            now_ns, has_news = self._native.advance(self.id, horizon_ns, until_ns)
            if has_news:
                self._interrupts()
            if now_ns >= horizon_ns:
                for device in self.devices:
                    if device.due_ns <= now_ns:
                        device.step(SimTimeNs(now_ns))
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
