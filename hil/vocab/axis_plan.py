"""Plan that an axis is opened with, and its pins, by the control law that a profile names."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

PINS = {"D0": 0, "D1": 1, "D2": 2, "D3": 3, "dir": 0, "step": 1, "enable": 2}
"""Inputs of a servo: the board's names, and what the step/dir interface uses them for."""
STEPPER_PINS = {"sync": 0, "Estop": 1, "RST": 2, "EnA": 3, "EnB": 4}
"""Inputs of a stepper's controller."""
OUTPUTS = {"clk": 0, "dir": 1, "OP_SA": 2, "OP_SB": 3, "MS1": 4, "MS2": 5, "MS3": 6}
"""Outputs of a stepper's controller."""
CLOCK_OUT, CLOCK_IN, CLOCK_OUT_HZ = "clock", "xclk", 1_000_000
"""A stepper controller's clock output and its input for one: frequencies and not edges."""

MAX_WIRES = 16
"""Maximum number of wires from one board's outputs; ``STEPPER_WIRES`` in ``native/stepper.h``."""


class Pins(NamedTuple):
    """A kind of board's pins by name; two names of one number are the same pin."""

    inputs: Mapping[str, int]
    outputs: Mapping[str, int]


AXIS_PINS = {"mechaduino": Pins(PINS, {}), "sac": Pins(STEPPER_PINS, OUTPUTS)}
"""Pins that wires can join, by law."""

_MOTOR = (
    "inertia_kg_m2",
    "viscous_Nm_s_per_rad",
    "torque_constant_Nm_per_A",
    "start_deg",
    "load_torque_Nm",
    "rotor_teeth",
)
AXIS_PARAMETERS = {
    "mechaduino": (*_MOTOR, "sense_resistor_ohm"),
    "sac": (*_MOTOR, "phase_current_A", "driver"),
}
"""Numbers that a profile gives for its motor, driver and load, by control law: the Mechaduino's closed loop,
or the SAC's motion engine."""

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
"""Numbers that the full plant needs besides."""

FULL_SCALE_V = 0.33
"""Full scale of the Mechaduino's current command, at the driver's sense resistor: 3.3 V / 10."""


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
    end_stops: bool = False
    """Whether min_deg and max_deg apply."""


@dataclass(frozen=True)
class AxisPlan:
    """Plan of an axis: the plant, its numbers by ``AXIS_PARAMETERS`` and ``FULL_PARAMETERS``, its load, and
    the seed of its randomness."""

    parameters: Mapping[str, float]
    plant: Literal["simple", "full"] = "simple"
    load: Load = Load()
    seed: int = 0
    law: str = "mechaduino"

    @property
    def holding_Nm(self) -> float:
        """Maximum torque of the motor, without that of its magnets."""
        of = self.parameters
        most_A = of["phase_current_A"] if self.law == "sac" else FULL_SCALE_V / of["sense_resistor_ohm"]
        return of["torque_constant_Nm_per_A"] * most_A
