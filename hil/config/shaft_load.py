"""Kinds of load on the shaft of the full plant. Units and signs are the axis's own: positive is towards
larger encoder counts."""

from collections.abc import Mapping
from math import tau
from typing import Annotated, Literal

from pydantic import BaseModel, Field, model_validator
from pydantic_core import PydanticCustomError

from hil.config.explain import StrictModel
from hil.vocab.axis_plan import Load

STANDARD_GRAVITY_m_per_s2 = 9.80665

_Positive = Annotated[float, Field(gt=0, le=1e6)]
_Number = Annotated[float, Field(ge=-1e6, le=1e6)]


class _Load(StrictModel):
    inertia_kg_m2: float = Field(
        default=0.0, ge=0, le=1e6, description="Moment of inertia of what turns with the shaft, in kg m2."
    )
    friction_Nm: float = Field(
        default=0.0, ge=0, le=1e6, description="Dry friction of what it turns, beside the motor's own."
    )
    viscous_Nm_s_per_rad: float = Field(
        default=0.0, ge=0, le=1e6, description="Friction of what it turns that grows with the speed."
    )

    def with_friction(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Add its friction to the parameters of an axis."""
        own = {"coulomb_torque_Nm": self.friction_Nm, "viscous_Nm_s_per_rad": self.viscous_Nm_s_per_rad}
        return {name: value + own.get(name, 0.0) for name, value in parameters.items()}


class ConstantLoad(_Load):
    """A torque that never changes."""

    kind: Literal["constant"]
    torque_Nm: _Number = Field(
        default=0.0,
        description="Torque on the shaft in Nm, positive towards larger encoder counts; up to ten times what"
        " the motor holds.",
    )

    def parts(self) -> Load:
        return Load(inertia_kg_m2=self.inertia_kg_m2, torque_Nm=self.torque_Nm)


class SpringLoad(_Load):
    """A torsion spring."""

    kind: Literal["spring"]
    stiffness_Nm_per_rad: _Positive = Field(description="Torque for each radian, in Nm/rad.")
    centre_deg: _Number = Field(
        default=0.0, description="Shaft angle at which the spring is slack, in degrees."
    )

    def parts(self) -> Load:
        return Load(
            inertia_kg_m2=self.inertia_kg_m2,
            stiffness_Nm_per_rad=self.stiffness_Nm_per_rad,
            centre_deg=self.centre_deg,
        )


class PendulumLoad(_Load):
    """A point mass on an arm without weight. Adds the inertia mass * length^2."""

    kind: Literal["pendulum"]
    mass_kg: _Positive = Field(description="Mass at the end of the arm, in kg.")
    length_m: _Positive = Field(description="Length of the arm, in m.")
    centre_deg: _Number = Field(
        default=0.0, description="Shaft angle at which the arm hangs down, in degrees."
    )

    def parts(self) -> Load:
        return Load(
            inertia_kg_m2=self.inertia_kg_m2 + self.mass_kg * self.length_m**2,
            pendulum_Nm=self.mass_kg * STANDARD_GRAVITY_m_per_s2 * self.length_m,
            centre_deg=self.centre_deg,
        )


class LeadScrewLoad(_Load):
    """A carriage on a screw without losses. Adds the inertia mass * (lead / one turn)^2."""

    kind: Literal["lead_screw"]
    lead_mm: _Positive = Field(description="Travel in one turn of the shaft, in mm.")
    mass_kg: _Positive = Field(description="Mass of the carriage, in kg.")
    gravity: Literal["none", "positive", "negative"] = Field(
        default="none",
        description="Whether the carriage's weight turns the shaft, and which way: `positive` is towards"
        " larger encoder counts.",
    )

    def parts(self) -> Load:
        metres_per_rad = self.lead_mm / 1000 / tau
        sign = {"none": 0, "positive": 1, "negative": -1}[self.gravity]
        return Load(
            inertia_kg_m2=self.inertia_kg_m2 + self.mass_kg * metres_per_rad**2,
            torque_Nm=sign * self.mass_kg * STANDARD_GRAVITY_m_per_s2 * metres_per_rad,
        )


class EndStopsLoad(_Load):
    """Two hard stops with some damping; they push, and never hold."""

    kind: Literal["end_stops"]
    min_deg: _Number = Field(description="Smallest shaft angle, in degrees, turns included.")
    max_deg: _Number = Field(description="Largest shaft angle, in degrees, turns included.")
    stop_Nm_per_rad: float | None = Field(
        default=None,
        gt=0,
        le=1e6,
        description="Stiffness of the stops: torque for each radian that the shaft is pressed into one; null:"
        " as stiff as a step of the plant resolves.",
    )

    @model_validator(mode="after")
    def _in_order(self) -> "EndStopsLoad":
        if self.min_deg >= self.max_deg:
            raise PydanticCustomError(
                "end_stops",
                "there is no room between the stops",
                {"remedy": "write a min_deg that is smaller than max_deg"},
            )
        return self

    def parts(self) -> Load:
        return Load(
            inertia_kg_m2=self.inertia_kg_m2,
            min_deg=self.min_deg,
            max_deg=self.max_deg,
            stop_Nm_per_rad=self.stop_Nm_per_rad or 0.0,
            end_stops=True,
        )


LOAD_KINDS: dict[str, type[BaseModel]] = {
    "constant": ConstantLoad,
    "spring": SpringLoad,
    "pendulum": PendulumLoad,
    "lead_screw": LeadScrewLoad,
    "end_stops": EndStopsLoad,
}

LoadConfig = Annotated[
    ConstantLoad | SpringLoad | PendulumLoad | LeadScrewLoad | EndStopsLoad, Field(discriminator="kind")
]
