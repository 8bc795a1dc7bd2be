"""Lights of the board: the LED with its pattern, and the channels of the light driver."""

from collections.abc import Mapping, Sequence

from device_profiles.walter.arm_parts import SAMPLE_MS
from device_profiles.walter.settings import Setting

_BIT_MS = 100
READY = (0b11001000, 0b00001100, 0b10000000)
IDLE = (0b10000000, 0b00000000)
ON, OFF = (0b11111111,), (0b00000000,)
_CHANNELS = {9: 0, 8: 1, 11: 2, 10: 3, 13: 4, 12: 5, 15: 6}
"""Actuators by their channels."""
_BEAT_COUNTS, _FALL_COUNTS, _BEAT = 100, 15, 60


class Lights:
    """Lights as a function of the time: nobody has to count them."""

    def __init__(self) -> None:
        self.is_setting_up = False
        self.is_enabled = False
        self.had_knob = False
        self.limits: Sequence[Setting] = ()
        """Settings as of the last set-up."""
        self._pattern: Sequence[int] = ON
        self._since_ms = 0

    def show(self, pattern: Sequence[int], now_ms: int) -> None:
        """Let the LED show a pattern from its beginning, a bit each 100 ms."""
        self._pattern, self._since_ms = pattern, now_ms

    def led(self, now_ms: int) -> bool:
        """Level of the LED."""
        bit = (now_ms - self._since_ms) // _BIT_MS % (8 * len(self._pattern))
        return bool(self._pattern[bit // 8] >> (7 - bit % 8) & 1)

    def channels(self, angles_deg: Sequence[float], now_ms: int) -> Mapping[int, int]:
        """Brightness, 0 to 255, by channel; those that are never lit are left out."""
        count = now_ms // SAMPLE_MS % _BEAT_COUNTS
        fall = _BEAT - 10 * count if count < _FALL_COUNTS else _BEAT - 3 * (count - _FALL_COUNTS)
        lit = {0: 100 * self.is_setting_up, 1: max(0, fall), 2: 100 * self.is_enabled, 7: 100 * self.had_knob}
        for channel, number in _CHANNELS.items():
            lit[channel] = self._place(number, angles_deg[number]) if self.is_enabled and self.limits else 0
        return lit

    def _place(self, number: int, deg: float) -> int:
        limits = self.limits[number]
        if limits.max_deg == limits.min_deg:
            return 0
        return int((deg - limits.min_deg) / (limits.max_deg - limits.min_deg) * 150) & 0xFF
