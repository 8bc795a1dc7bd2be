"""Plan that an axis is opened with."""

from collections.abc import Mapping
from dataclasses import field
from math import inf
from typing import Literal, NamedTuple

from hil.vocab.late_dataclass import dataclass
from hil.vocab.own_fields import OwnField

FULL_PARAMETERS = (
    "phase_resistance_ohm",
    "phase_inductance_H",
    "supply_V",
    "detent_torque_Nm",
    "coulomb_torque_Nm",
    "full_step_error_pct",
    "encoder_eccentricity_deg",
    "encoder_nonlinearity_deg",
    "encoder_noise_counts",
)
"""Numbers that only the full plant needs."""


@dataclass(frozen=True)
class Load:
    """Load on the shaft of a full plant; the parts add up. ``hil/core/native/types.h``: hil_load."""

    inertia_kg_m2: float = 0.0
    torque_Nm: float = 0.0
    stiffness_Nm_per_rad: float = 0.0
    pendulum_Nm: float = 0.0
    """Amplitude of the pendulum's torque: weight times length."""
    centre_deg: float = 0.0
    """Angle at which spring and pendulum rest."""
    min_deg: float = 0.0
    max_deg: float = 0.0
    stop_Nm_per_rad: float = 0.0
    """Stiffness of both stops; 0: as stiff as a step of the plant resolves."""
    end_stops: bool = False
    """True if ``min_deg`` and ``max_deg`` apply."""


@dataclass(frozen=True)
class ProcessorPlan:
    """Plan of a processor whose pins an axis is: its clock, its voltages, its fuses low, high and extended,
    and the board's names of its pins."""

    clock_Hz: int = 16_000_000
    supply_V: float = 5.0
    aref_V: float = 5.0
    fuses: tuple[int, int, int] = (0xFF, 0xDE, 0xFD)
    pins: tuple[tuple[str, int], ...] = ()
    """Numbers of its pins by their names on the board, 0 to 19 for PD0 to PD7, PB0 to PB5 and PC0 to PC5, 20
    and 21 for ADC6 and ADC7; empty: the names are a Uno's."""


@dataclass(frozen=True)
class AxisPlan:
    """Plan of an axis: the plant, its numbers (``AxisKind.parameters``, ``FULL_PARAMETERS``), its load, and
    the seed of its randomness."""

    parameters: Mapping[str, float]
    plant: Literal["simple", "full"] = "simple"
    load: Load = Load()
    seed: int = 0
    law: str = field(kw_only=True)
    processor: ProcessorPlan | None = None
    """Plan of the processor of pins; None: they have a Uno's."""
    fields: tuple[OwnField, ...] = ()
    """Fields of the board's own, which this axis has."""


class FollowedSpeed(NamedTuple):
    """Speeds in rpm: up to ``whole_rpm`` the motor has its whole torque, above ``last_rpm`` it cannot follow.
    They differ only with the full plant. ``inf`` of an axis without a motor; 0: the load is too heavy."""

    whole_rpm: float = inf
    last_rpm: float = inf
