"""Session of a SAC, which lasts until the next reset."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

from device_profiles.sac.parameters import Parameters
from device_profiles.sac.typed_text import Attributes, Velocity
from hil.vocab.motion import MotionEntry


class Session:
    """Parameters in force, defaults of the next command, and flags."""

    default: MotionEntry
    """Attributes of the next command where its line says nothing."""

    def __init__(self, parameters: Parameters) -> None:
        self.restart(parameters)

    def restart(self, parameters: Parameters) -> None:
        """Take new parameters, at a cold start and by ``$R`` (decision: debug, GAP testing and encoder mode
        too)."""
        self.parameters = parameters
        self.default = replace(parameters.default_entry(), steps=0)
        self.is_debug = False
        self.is_gap_on = True
        self.is_throttle = False
        self.is_soft_ops_on = bool(parameters.soft_ops)
        self.is_ack_on = bool(parameters.ack)
        self.is_crc_on = bool(parameters.crc)

    def say(self, said: Attributes) -> None:
        """Change the defaults by a unary command."""
        self.default = said.apply(self.default, self.parameters.ramp)

    def say_velocity(self, velocity: Velocity) -> None:
        """Change the default velocity alone."""
        now = self.default
        before, by, after = _last_change[0]
        if before is now and by is velocity:
            self.default = after
        elif now.rpm != velocity.rpm or now.cycle_us != velocity.cycle_us:
            self.default = _at(now, velocity)
            _last_change[0] = now, velocity, self.default

    def command(self, said: Attributes) -> MotionEntry:
        """Make a typed motion command on the defaults, except direction, wait and sync."""
        if said.is_ccw is None:
            said.is_ccw = self.parameters.default_entry().is_ccw
        return said.apply(self.default, self.parameters.ramp)

    def keep(self, entry: MotionEntry) -> None:
        """Make a queued command's attributes the defaults, all but steps, direction, wait and sync."""
        kept = self.default
        self.default = replace(entry, steps=kept.steps, is_ccw=kept.is_ccw, is_sync=False, wait_us=0)

    def lines(self) -> Iterator[str]:
        """Lines that ``cf`` shows: a name and a value each (decision)."""
        e = self.default
        yield f"v\t{e.rpm}"
        yield f"vc\t{e.cycle_us}"
        yield f"acc\t{e.acc_hundredths / 100:.2f}"
        yield f"dec\t{e.dec_hundredths / 100:.2f}"
        yield f"ramp\t{int(e.is_linear)}"
        yield f"dir\t{'CCW' if e.is_ccw else 'CW'}"
        yield f"u\t{e.extra_pulses}"
        yield f"full\t{int(not e.is_pulses)}"
        yield f"GAP\t{int(self.is_gap_on)}"
        yield f"soft_ops\t{int(self.is_soft_ops_on)}"
        yield f"ACK\t{int(self.is_ack_on)}"
        yield f"CRC\t{int(self.is_crc_on)}"
        yield f"{'EnT' if self.is_throttle else 'EnF'}\t1"
        yield f"debug\t{int(self.is_debug)}"


_last_change: list[tuple[Any, Any, Any]] = [(None, None, None)]
"""Last change of an entry: from, by this velocity, to. A packet to all has every node do the same, and their
entries become one: the cache of ``_at``, which compares them whole, is asked by the first. One tuple, as
benches of other threads change it too."""


@lru_cache(maxsize=4)
def _at(entry: MotionEntry, velocity: Velocity) -> MotionEntry:
    """Give an entry another velocity; cached, because a packet to all has every node do the same."""
    return replace(entry, rpm=velocity.rpm, cycle_us=velocity.cycle_us)
