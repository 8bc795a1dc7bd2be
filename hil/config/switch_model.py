"""Model of the switches along an axis. The descriptions are the reference's text."""

from math import inf
from typing import Annotated, Any, Literal

from pydantic import Field

from hil.config.explain import StrictModel
from hil.vocab.address import owner_of, pin_of

_Angle = Annotated[float, Field(ge=-1e6, le=1e6)]


class AxisSwitchConfig(StrictModel):
    """A switch at an axis: a limit switch, one for home, or an index once in a turn."""

    axis: str = Field(description="The axis that actuates it, as in `s1` or `arm.elbow`.")
    from_deg: _Angle | None = Field(
        default=None,
        description="Smallest angle at which the axis holds it, by the shaft's own angle (`hil zero` moves no"
        " switch); null: none, as of a limit switch at the lower end.",
    )
    to_deg: _Angle | None = Field(
        default=None, description="Largest such angle; null: none, as of a limit switch at the upper end."
    )
    hysteresis_deg: float = Field(
        default=0.0, ge=0, le=360, description="How far beyond these angles the axis has to go to let it go."
    )
    every_deg: float | None = Field(
        default=None,
        gt=0,
        le=1e6,
        description="It comes again each so many degrees, as an index does in each turn; null: it is there"
        " once.",
    )
    contact: Literal["normally_open", "normally_closed"] = Field(
        default="normally_open", description="Whether the axis closes its contact, or opens it."
    )
    closed: Literal["low", "high"] = Field(
        default="low",
        description="Level of the pin while the contact is closed: `low` to ground, with a pull-up; `high` to"
        " the supply, with a pull-down.",
    )
    bounce_ms: float = Field(
        default=0.0,
        ge=0,
        le=100,
        description="Longest time for which the contact bounces. Each change has a bounce of its own, of half"
        " this time up to all of it, with some toggles; the bench's `seed` says which.",
    )
    to: str | None = Field(
        default=None,
        description="The pin that it is wired to, as in `s1.Estop` or `u1.D2`; null: to none, as of a switch"
        " at an interface card (`switches` of a node on a bus).",
    )

    def members(self) -> tuple[str, ...]:
        """Devices that it joins."""
        pin = (owner_of(pin_of(self.to)[0]),) if self.to else ()
        return tuple(dict.fromkeys((owner_of(self.axis), *pin)))

    def native(self) -> dict[str, Any]:
        """Fields of the core's switch that are the configuration's: ``hil/core/native/types.h``."""
        return {
            "from_deg": -inf if self.from_deg is None else self.from_deg,
            "to_deg": inf if self.to_deg is None else self.to_deg,
            "hysteresis_deg": self.hysteresis_deg,
            "every_deg": self.every_deg or 0.0,
            "opens": self.contact == "normally_closed",
            "closed_level": self.closed == "high",
            "bounce_ns": round(self.bounce_ms * 1e6),
        }
