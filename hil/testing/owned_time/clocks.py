"""Clocks of a program on simulated time: those of ``time``, and the calendar of ``datetime``."""

import ctypes
import datetime as real_datetime
import gc
import struct
import time as real_time
import uuid
from collections.abc import Callable
from typing import Any

from hil.testing.owned_time.owned_locks import until_ns
from hil.testing.owned_time.turns import Turns
from hil.testing.serial_ports.system_calls import CLOCK_START_S
from hil.vocab.time import NS_PER_S

FIRST_DATE_S = real_datetime.datetime(2026, 1, 1, tzinfo=real_datetime.UTC).timestamp()
"""Date at which a program starts by default: the same in each run."""
_UUID_EPOCH_TICKS = 0x01B21DD213814000
"""Ticks of 100 ns from the first day of the Gregorian calendar to 1970 (RFC 9562, 5.1)."""
_localtime, _gmtime = real_time.localtime, real_time.gmtime
_strftime, _ctime, _asctime = real_time.strftime, real_time.ctime, real_time.asctime
_gettime, _gettime_ns = real_time.clock_gettime, real_time.clock_gettime_ns
_MONOTONIC = {
    getattr(real_time, name)
    for name in ("CLOCK_MONOTONIC", "CLOCK_MONOTONIC_RAW", "CLOCK_BOOTTIME")
    if hasattr(real_time, name)
}


class OwnedClock:
    """Clock that costs a look. An object, since classes keep clocks as attributes (``serial.Timeout``), where
    a function would be a method."""

    def __init__(self, turns: Turns, read: Callable[[int], float], name: str) -> None:
        self._turns, self._read = turns, read
        self.__name__ = self.__qualname__ = name

    def __call__(self) -> float:
        self._turns.look()
        return self._read(self._turns.now_ns)


class Clocks:
    """Clocks of a program whose date is ``date_s`` now, in seconds since 1970."""

    def __init__(self, turns: Turns, date_s: float = FIRST_DATE_S) -> None:
        self._turns = turns
        self.date_ns: Callable[[], int] = lambda: date_ns + turns.now_ns
        """Answers the date without a look."""
        start_ns, date_ns = round(CLOCK_START_S * NS_PER_S), round(date_s * NS_PER_S) - turns.now_ns
        self.time = OwnedClock(turns, lambda now_ns: (date_ns + now_ns) / NS_PER_S, "time")
        self.time_ns = OwnedClock(turns, lambda now_ns: date_ns + now_ns, "time_ns")
        self.monotonic = OwnedClock(turns, lambda now_ns: (start_ns + now_ns) / NS_PER_S, "monotonic")
        self.monotonic_ns = OwnedClock(turns, lambda now_ns: start_ns + now_ns, "monotonic_ns")

    def sleep(self, seconds: float) -> None:
        """Sleep in simulated time; 0 is a look."""
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        if seconds == 0:
            self._turns.look()
        else:
            self._turns.wait(lambda: False, until_ns(self._turns, seconds), "the end of a sleep")

    def of_time(self) -> dict[str, Any]:
        """Functions of ``time`` by name."""
        now = self.time

        def gettime(clock: int) -> float:
            """Read a clock by its number."""
            if clock in _MONOTONIC:
                return self.monotonic()
            return now() if clock == real_time.CLOCK_REALTIME else _gettime(clock)

        def gettime_ns(clock: int) -> float:
            """Read a clock by its number, in ns."""
            if clock in _MONOTONIC:
                return self.monotonic_ns()
            return self.time_ns() if clock == real_time.CLOCK_REALTIME else _gettime_ns(clock)

        return {
            "time": now,
            "time_ns": self.time_ns,
            "monotonic": self.monotonic,
            "monotonic_ns": self.monotonic_ns,
            "perf_counter": self.monotonic,
            "perf_counter_ns": self.monotonic_ns,
            "sleep": self.sleep,
            "clock_gettime": gettime,
            "clock_gettime_ns": gettime_ns,
            "localtime": lambda at=None: _localtime(now() if at is None else at),
            "gmtime": lambda at=None: _gmtime(now() if at is None else at),
            "ctime": lambda at=None: _ctime(now() if at is None else at),
            "asctime": lambda of=None: _asctime(_localtime(now()) if of is None else of),
            "strftime": lambda form, of=None: _strftime(form, _localtime(now()) if of is None else of),
        }

    def put_in_uuid(self) -> None:
        """Let ``uuid1`` read this clock."""
        make: Callable[[], tuple[bytes, int]] | None = getattr(uuid, "_generate_time_safe", None)
        if make is None:
            return  # it reads ``time.time_ns``

        def make_at_date() -> tuple[bytes, int]:
            made, is_safe = make()
            ticks = int(self.time_ns()) // 100 + _UUID_EPOCH_TICKS
            low, middle, high = ticks & 0xFFFFFFFF, ticks >> 32 & 0xFFFF, ticks >> 48 & 0xFFF | 0x1000
            return struct.pack(">IHH", low, middle, high) + made[8:], is_safe

        uuid._generate_time_safe = make_at_date  # type: ignore[attr-defined]

    def put_in_datetime(self) -> None:
        """Let ``datetime.now`` and ``utcnow`` read this clock. Python's own classes stay, so that each object
        of theirs is still one; ``today`` reads ``time.time``."""
        now = self.time

        def read_now(cls: type[Any], tz: real_datetime.tzinfo | None = None) -> Any:
            """Current local date and time, or of a time zone."""
            return cls.fromtimestamp(now(), tz)

        def read_utcnow(cls: type[Any]) -> Any:
            """Current date and time in UTC, without a time zone."""
            return cls.fromtimestamp(now(), real_datetime.UTC).replace(tzinfo=None)

        kind = real_datetime.datetime
        members = gc.get_referents(kind.__dict__)[0]  # a type of C takes no attributes
        members |= {"now": classmethod(read_now), "utcnow": classmethod(read_utcnow)}
        ctypes.pythonapi.PyType_Modified(ctypes.py_object(kind))
