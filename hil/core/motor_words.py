"""Words on how a motor follows what it is told, for status, events and checks."""

from collections.abc import Mapping

from hil.core.core_axis import CoreAxis
from hil.vocab.axis_plan import FollowedSpeed

STANDS_RPM = 1.0
"""Speed below which a shaft stands; that of a servo that holds its place."""


def blocked_note(shot: Mapping[str, float], axis: CoreAxis) -> str:
    """Note on a servo that pushes with its whole effort, and stands; empty: it does not, or its kind has no
    effort."""
    if not axis.kind.is_at_limit(shot):
        return ""
    return "it pushes with its whole effort, and stands" if abs(shot["velocity_rpm"]) < STANDS_RPM else ""


def stall_note(shot: Mapping[str, float], axis: CoreAxis) -> str:
    """Note on steps that a motor has lost since power-up; empty: none, or its kind tells none."""
    stalls = int(shot.get("stalls", 0))
    if not stalls:
        return ""
    often = "once" if stalls == 1 else f"{stalls} times"
    return (
        f"it lost steps {often}, at {shot['stalled_at_ns'] / 1e9:.3f} s last; {followed_text(axis.followed)}"
    )


def heat_note(shot: Mapping[str, float]) -> str:
    """Note on a driver that is too hot, or was; empty: it never was, or its kind has no heat."""
    trips = int(shot.get("thermal_trips", 0))
    if not trips:
        return ""
    if shot["is_too_hot"]:
        return f"its driver is too hot ({shot['junction_degC']:.0f} degC): no current until it has cooled"
    often = "once" if trips == 1 else f"{trips} times"
    return f"its driver was too hot {often}; its current is back since {shot['cooled_at_ns'] / 1e9:.3f} s"


def followed_text(followed: FollowedSpeed) -> str:
    """Text on the speeds that a motor follows by its figures."""
    if followed.whole_rpm == followed.last_rpm:
        return f"by its figures the motor follows up to {followed.last_rpm:.0f} rpm"
    return (
        f"by its figures the motor has its whole torque up to {followed.whole_rpm:.0f} rpm, less above it,"
        f" and none from {followed.last_rpm:.0f} rpm on"
    )
