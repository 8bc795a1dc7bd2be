"""Clocks of a program on simulated time: those of ``time``, and the calendar of ``datetime``."""

import datetime as real_datetime
import time as real_time
from collections.abc import Callable
from typing import Any

from hil.testing.owned_time.owned_locks import until_ns
from hil.testing.owned_time.turns import Turns
from hil.testing.serial_ports.system_calls import CLOCK_START_S
from hil.vocab.time import NS_PER_S

FIRST_DATE_S = real_datetime.datetime(2026, 1, 1, tzinfo=real_datetime.UTC).timestamp()
"""Date at which a program starts by default: the same in each run."""
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

    def __init__(self, turns: Turns, read: Callable[[int], float]) -> None:
        self._turns, self._read = turns, read

    def __call__(self) -> float:
        self._turns.look()
        return self._read(self._turns.now_ns)


class Clocks:
    """Clocks of a program whose date is ``date_s`` now, in seconds since 1970."""

    def __init__(self, turns: Turns, date_s: float = FIRST_DATE_S) -> None:
        self._turns = turns
        start_ns, date_ns = round(CLOCK_START_S * NS_PER_S), round(date_s * NS_PER_S) - turns.now_ns
        self.time = OwnedClock(turns, lambda now_ns: (date_ns + now_ns) / NS_PER_S)
        self.time_ns = OwnedClock(turns, lambda now_ns: date_ns + now_ns)
        self.monotonic = OwnedClock(turns, lambda now_ns: (start_ns + now_ns) / NS_PER_S)
        self.monotonic_ns = OwnedClock(turns, lambda now_ns: start_ns + now_ns)

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

    def of_datetime(self) -> dict[str, type[Any]]:
        """Classes of ``datetime`` by name."""
        now = self.time

        class DateKind(type):
            def __instancecheck__(cls, each: object) -> bool:
                return isinstance(each, cls._real)  # type: ignore[attr-defined]

            def __subclasscheck__(cls, each: type) -> bool:
                return issubclass(each, cls._real)  # type: ignore[attr-defined]

        class date(real_datetime.date, metaclass=DateKind):  # noqa: N801 - its name
            _real = real_datetime.date

            @classmethod
            def today(cls) -> Any:
                return cls.fromtimestamp(now())

        class datetime(real_datetime.datetime, metaclass=DateKind):  # noqa: N801 - its name
            _real = real_datetime.datetime

            @classmethod
            def now(cls, tz: real_datetime.tzinfo | None = None) -> Any:
                return cls.fromtimestamp(now(), tz)

            @classmethod
            def today(cls) -> Any:
                return cls.fromtimestamp(now())

            @classmethod
            def utcnow(cls) -> Any:
                return cls.fromtimestamp(now(), real_datetime.UTC).replace(tzinfo=None)

        for each in (date, datetime):
            each.__module__, each.__qualname__ = "datetime", each.__name__
        return {"date": date, "datetime": datetime}
