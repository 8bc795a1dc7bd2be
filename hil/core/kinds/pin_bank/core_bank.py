"""The pins of a microcontroller, with names instead of numbers."""

from collections.abc import Sequence

from hil.core.core_axis import CoreAxis
from hil.vocab.pins import Pulses


class CoreBank(CoreAxis):
    """Pins of a microcontroller; a firmware sees them as ``hil.vocab.pins.Pins``."""

    def loop(self, on: bool) -> None:
        """End all pulses where a control loop would be stopped."""
        if not on:
            self._native.bank_pulses(self.id, 0, [])

    def write(self, pin: str, level: int) -> None:
        self._native.bank_write(self.id, self.pins[pin], level)

    def let_go(self, pin: str) -> None:
        self._native.bank_write(self.id, self.pins[pin], -1)

    def read(self, pin: str) -> int:
        return self._native.bank_read(self.id, self.pins[pin])

    def pulse(self, pin: str, rows: Sequence[Pulses]) -> None:
        self._native.bank_pulses(self.id, self.pins[pin], [(r.number, r.period_ns, r.high_ns) for r in rows])

    @property
    def pulses_left(self) -> int:
        return int(self.get("pulses_left"))
