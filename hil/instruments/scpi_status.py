"""Status of an instrument with SCPI's forms: queue of errors, event register, their sums, and what sets them.

Sources: IEEE 488.2, 11 (registers and their bits) and 10 (commands); SCPI 1999, volume 2, 21.8 (errors).
"""

from collections import deque

from hil.instruments.table_expressions import Value

ERROR = "error"
"""Name in a template for the next error of the queue, which leaves it."""
EVENTS, EVENTS_ENABLED, STATUS, REQUESTS_ENABLED = "*ESR", "*ESE", "*STB", "*SRE"
"""Names of the registers, none of which a variable can have. A look at ``EVENTS`` clears it."""
NAMES = frozenset({ERROR, EVENTS, EVENTS_ENABLED, STATUS, REQUESTS_ENABLED})
COMPLETE, POWER_ON = 1, 128
"""Bits of the event register that no error sets."""
_BIT_OF_CLASS = {1: 32, 2: 16, 3: 8, 4: 4, 5: 128, 6: 64, 7: 2, 8: 1}
"""Bit of the event register by the hundreds of an error's number, -100 to -899."""
_MOST_LETTERS = 8
_OF_DEVICE = 8
"""Bit for a device's own errors, which have positive numbers, or none."""
_QUEUE, _ANSWER, _EVENT, _MASTER = 4, 16, 32, 64
"""Bits of the status byte: an error waits, an answer waits, an enabled event, the sum of those enabled."""


class ScpiStatus:
    """Status of one power-up. ``longest``: errors that wait, 0: the table has no queue; ``no_error``: answer
    of an empty one; ``overflow``: text that replaces the last error of a full one."""

    def __init__(self, longest: int, no_error: str, overflow: str) -> None:
        self._longest, self._no_error, self._overflow = longest, no_error, overflow
        self._errors: deque[str] = deque()
        self._events = POWER_ON
        self._enabled = {EVENTS_ENABLED: 0, REQUESTS_ENABLED: 0}
        self.has_answer = False
        """True if an answer to an earlier command of the line waits."""

    def note(self, error: str) -> None:
        """Put an error in the queue, and its bit in the event register."""
        self._events |= event_bit(error)
        if len(self._errors) < self._longest:
            self._errors.append(error)
        else:
            self._errors[-1] = self._overflow or error
            self._events |= event_bit(self._errors[-1])

    def look(self, name: str) -> Value:
        """Value of one of ``NAMES``."""
        if name == ERROR:
            return self._errors.popleft() if self._errors else self._no_error
        if name == EVENTS:
            events, self._events = self._events, 0
            return float(events)
        return float(self._byte() if name == STATUS else self._enabled[name])

    def put(self, name: str, value: float) -> None:
        """Set what enables, or bits of the event register."""
        if name == EVENTS:
            self._events |= int(value)
        else:
            self._enabled[name] = int(value) & ~(_MASTER if name == REQUESTS_ENABLED else 0)

    def clear(self) -> None:
        """Empty the queue and the event register; what enables stays."""
        self._errors.clear()
        self._events = 0

    def _byte(self) -> int:
        byte = _QUEUE * bool(self._errors) | _ANSWER * self.has_answer
        byte |= _EVENT * bool(self._events & self._enabled[EVENTS_ENABLED])
        return byte | _MASTER * bool(byte & self._enabled[REQUESTS_ENABLED])


def event_bit(error: str) -> int:
    """Bit of the event register that an error sets, by its number, as in ``-222,"Data out of range"``."""
    number = error.partition(",")[0].strip()
    if not number.startswith("-") or not number[1:].isdecimal() or len(number) > _MOST_LETTERS:
        return _OF_DEVICE
    return _BIT_OF_CLASS.get(int(number[1:]) // 100, _OF_DEVICE)
