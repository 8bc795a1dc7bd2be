"""Catalogue of motors that a ``profile.yaml`` or a device may name, as in ``motor: nema17-2A``, instead of
writing out their numbers. Each number has its origin."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from hil.vocab.late_dataclass import dataclass


class Figure(NamedTuple):
    """Number of a motor; ``full`` is the full plant's, where it differs."""

    value: float
    source: str
    full: float | None = None


@dataclass(frozen=True)
class Motor:
    """Motor at its rated current. The origin of a figure says whether its data sheet was read, or sellers."""

    title: str
    figures: Mapping[str, Figure]
    rated_A: float
    holding_Nm: float
    """Holding torque with two coils at the rated current, as the maker or sellers quote it."""

    @property
    def steps(self) -> int:
        """Full steps in a turn."""
        return round(4 * self.figures["rotor_teeth"].value)


MEANINGS: dict[str, dict[str, Any]] = {
    "inertia_kg_m2": {
        "unit": "kg m2",
        "above": 0,
        "about": "Moment of inertia of the rotor and what turns with it.",
    },
    "viscous_Nm_s_per_rad": {
        "unit": "Nm s/rad",
        "minimum": 0,
        "about": "Friction that grows with the speed.",
    },
    "torque_constant_Nm_per_A": {
        "unit": "Nm/A",
        "above": 0,
        "about": "Torque of one coil for each ampere, at the angle where it pulls most.",
    },
    "rotor_teeth": {
        "unit": "teeth",
        "minimum": 1,
        "maximum": 1000,
        "whole": True,
        "about": "Teeth of the rotor; four full steps turn it by one tooth.",
    },
    "start_deg": {"unit": "deg", "minimum": -1e6, "maximum": 1e6, "about": "Shaft angle at power-up."},
    "load_torque_Nm": {
        "unit": "Nm",
        "minimum": -1e6,
        "maximum": 1e6,
        "about": "External torque on the shaft; up to ten times what the motor holds.",
    },
    "supply_V": {
        "unit": "V",
        "above": 0,
        "about": "Supply voltage of the driver; must be in its range. The simple plant has no limit from it.",
    },
    "phase_resistance_ohm": {"unit": "ohm", "above": 0, "about": "Resistance of one coil. Full plant only."},
    "phase_inductance_H": {"unit": "H", "above": 0, "about": "Inductance of one coil. Full plant only."},
    "detent_torque_Nm": {
        "unit": "Nm",
        "minimum": 0,
        "about": "Largest torque of the magnets without current; four periods to one of the current."
        " Full plant only.",
    },
    "coulomb_torque_Nm": {
        "unit": "Nm",
        "minimum": 0,
        "about": "Dry friction; a stopped shaft stays under less than this. Full plant only.",
    },
    "full_step_error_pct": {
        "unit": "% of a full step",
        "minimum": 0,
        "maximum": 100,
        "about": "Amplitude of the once-per-turn error of the motor's magnetic angle. Full plant only.",
    },
    "encoder_eccentricity_deg": {
        "unit": "deg",
        "minimum": 0,
        "maximum": 20,
        "about": "Amplitude of the encoder's once-per-turn error. Full plant only.",
    },
    "encoder_nonlinearity_deg": {
        "unit": "deg",
        "minimum": 0,
        "maximum": 10,
        "about": "Amplitude of the encoder's twice-per-turn error. Full plant only.",
    },
    "encoder_noise_counts": {
        "unit": "counts rms",
        "minimum": 0,
        "maximum": 1000,
        "about": "Noise of a reading. Full plant only.",
    },
}
"""Units, limits and meanings of the numbers that come with a motor."""

_AROUND = {
    "start_deg": Figure(0.0, "chosen"),
    "load_torque_Nm": Figure(0.0, "a bare shaft"),
    "supply_V": Figure(12.0, "chosen, usual bench supplies", 24.0),
    "encoder_eccentricity_deg": Figure(0.0, "no encoder, or a perfect one"),
    "encoder_nonlinearity_deg": Figure(0.0, "no encoder, or a perfect one"),
    "encoder_noise_counts": Figure(0.0, "no encoder, or a perfect one"),
}
"""Numbers around a motor, which a board gives if it has others."""

_BEARINGS = "chosen: bearings and the iron's hysteresis, see docs/decisions/0008"
_DETENT = "chosen, a thirtieth of the holding torque as usual for the size"
_DAMPING = (
    "chosen: the damping of nema17-2A, by the root of holding torque times inertia; full: bearings alone"
)


def _as_sold(
    motor: str,
    size: str,
    *,
    holding_Nm: float,
    rated_A: float,
    torque_constant_Nm_per_A: float,
    inertia_kg_m2: float,
    viscous_Nm_s_per_rad: tuple[float, float],
    phase_resistance_ohm: float,
    phase_inductance_H: float,
    detent_torque_Nm: float,
    coulomb_torque_Nm: float,
) -> Motor:
    """Motor of which there are only the figures that sellers quote. ``viscous_Nm_s_per_rad``: of the simple
    plant and the full one."""
    quoted, holding, rated = f"{motor} as sellers quote it", f"{holding_Nm:g} Nm", f"{rated_A:g} A"
    return Motor(
        f"{motor}: {size}, {holding} at {rated}",
        _AROUND
        | {
            "inertia_kg_m2": Figure(inertia_kg_m2, f"{quoted}, rotor {inertia_kg_m2 * 1e7:g} g cm2"),
            "viscous_Nm_s_per_rad": Figure(viscous_Nm_s_per_rad[0], _DAMPING, viscous_Nm_s_per_rad[1]),
            "torque_constant_Nm_per_A": Figure(
                torque_constant_Nm_per_A, f"{quoted}, {holding} holding torque with two coils at {rated}"
            ),
            "rotor_teeth": Figure(50, f"{motor}, 200 steps a turn"),
            "phase_resistance_ohm": Figure(phase_resistance_ohm, quoted),
            "phase_inductance_H": Figure(phase_inductance_H, quoted),
            "detent_torque_Nm": Figure(detent_torque_Nm, _DETENT),
            "coulomb_torque_Nm": Figure(coulomb_torque_Nm, _BEARINGS),
            "full_step_error_pct": Figure(5.0, f"{quoted}, step angle accuracy +-5 %"),
        },
        rated_A,
        holding_Nm,
    )


class _Row(NamedTuple):
    """Figures of a motor as its source has them. ``detent_Nm`` 0: the source has none."""

    motor: str
    size: str
    holding_Nm: float
    rated_A: float
    resistance_ohm: float
    inductance_mH: float
    rotor_g_cm2: float
    detent_Nm: float = 0.0
    steps: int = 200
    source: str = "as sellers quote it"


_QSH5718 = "Trinamic QSH5718 data sheet, table 2.1"
_QSH8618 = "Trinamic QSH8618 manual, table 2.1"
_ROWS = {
    "nema14-0.5A": _Row("14HS17-0504S", "35 x 42 mm", 0.23, 0.5, 15.0, 26.0, 18),
    "nema14-0.8A": _Row("14HS13-0804S", "35 x 34 mm", 0.18, 0.8, 6.8, 10.0, 14),
    "nema17-1.7A": _Row("17HS19-1684S1", "42 x 48 mm", 0.45, 1.7, 1.65, 2.8, 68),
    "nema17-1A-400": _Row("17HM15-1004S", "42 x 40 mm", 0.33, 1.0, 4.5, 12.5, 54, steps=400),
    "nema17-2A-400": _Row("17HM19-2004S", "42 x 48 mm", 0.46, 2.0, 1.45, 4.0, 82, steps=400),
    "nema23-2.8A-short": _Row(
        "QSH5718-41-28-055", "57 x 41 mm", 0.55, 2.8, 0.7, 1.4, 120, 0.020, source=_QSH5718
    ),
    "nema23-2.8A-long": _Row(
        "QSH5718-76-28-189", "57 x 76 mm", 1.89, 2.8, 1.13, 3.6, 480, 0.066, source=_QSH5718
    ),
    "nema23-3A": _Row("23HS30-3004S", "57 x 76 mm", 1.89, 3.0, 1.13, 4.8, 440),
    "nema34-3A": _Row(
        "QSH8618-65-59-340, coils in series", "86 x 65 mm", 3.4, 3.0, 1.14, 6.8, 1000, 0.078, source=_QSH8618
    ),
    "nema34-5.5A": _Row("QSH8618-80-55-460", "86 x 80 mm", 4.6, 5.5, 0.42, 3.5, 1400, 0.117, source=_QSH8618),
    "nema34-6A": _Row("QSH8618-118-60-870", "86 x 118 mm", 8.7, 6.0, 0.45, 5.1, 2700, 0.235, source=_QSH8618),
}
_BARE_FRICTION = {"nema14": (2.0e-5, 0.004), "nema17": (4.0e-5, 0.008), "nema23": (1.0e-4, 0.02)}
"""Viscous (Nm s/rad) and dry (Nm) friction of bearings by size; of larger ones as below."""
_LARGE_FRICTION = (3.0e-4, 0.05)
_FIRST = 0.0015, 0.45 * 5.4e-6
"""Damping of nema17-2A with the simple plant, and its holding torque times inertia."""


def _of_row(name: str, row: _Row) -> Motor:
    viscous, dry_Nm = _BARE_FRICTION.get(name.partition("-")[0], _LARGE_FRICTION)
    inertia_kg_m2, quoted = row.rotor_g_cm2 * 1e-7, f"{row.motor}: {row.source}"
    damping = _FIRST[0] * math.sqrt(row.holding_Nm * inertia_kg_m2 / _FIRST[1])
    holding = f"{row.holding_Nm:g} Nm holding torque with two coils at {row.rated_A:g} A"
    torque_constant = row.holding_Nm / (math.sqrt(2) * row.rated_A)
    figures = {
        "inertia_kg_m2": Figure(inertia_kg_m2, f"{quoted}, rotor {row.rotor_g_cm2:g} g cm2"),
        "viscous_Nm_s_per_rad": Figure(float(f"{damping:.2g}"), _DAMPING, viscous),
        "torque_constant_Nm_per_A": Figure(float(f"{torque_constant:.4g}"), f"{quoted}, {holding}"),
        "rotor_teeth": Figure(row.steps / 4, f"{quoted}, {row.steps} steps a turn"),
        "phase_resistance_ohm": Figure(row.resistance_ohm, quoted),
        "phase_inductance_H": Figure(float(f"{row.inductance_mH * 1e-3:.6g}"), quoted),
        "detent_torque_Nm": Figure(
            row.detent_Nm or float(f"{row.holding_Nm / 30:.2g}"), quoted if row.detent_Nm else _DETENT
        ),
        "coulomb_torque_Nm": Figure(dry_Nm, _BEARINGS),
        "full_step_error_pct": Figure(5.0, f"{quoted}, step angle accuracy +-5 %"),
    }
    steps = "" if row.steps == 200 else f", {row.steps} steps"
    title = f"{row.motor}: {row.size}{steps}, {row.holding_Nm:g} Nm at {row.rated_A:g} A"
    return Motor(title, _AROUND | figures, row.rated_A, row.holding_Nm)


MOTORS: Mapping[str, Motor] = {
    "nema17-2A": Motor(
        "17HS16-2004S1: 42 x 40 mm, 0.45 Nm at 2 A",
        _AROUND
        | {
            "inertia_kg_m2": Figure(5.4e-6, "17HS16-2004S1 data sheet, rotor 54 g cm2"),
            "viscous_Nm_s_per_rad": Figure(
                0.0015,
                "chosen: the simple plant then takes full steps at 10 to 800 RPM without swinging out of"
                " step; full: bearings alone",
                4.0e-5,
            ),
            "torque_constant_Nm_per_A": Figure(
                0.155, "17HS16-2004S1 data sheet, 0.45 Nm holding torque with two coils at 2 A"
            ),
            "rotor_teeth": Figure(50, "17HS16-2004S1 data sheet, 200 steps a turn"),
            "phase_resistance_ohm": Figure(1.1, "17HS16-2004S1 data sheet"),
            "phase_inductance_H": Figure(2.6e-3, "17HS16-2004S1 data sheet"),
            "detent_torque_Nm": Figure(0.015, _DETENT),
            "coulomb_torque_Nm": Figure(0.008, _BEARINGS),
            "full_step_error_pct": Figure(5.0, "17HS16-2004S1 data sheet, step angle accuracy +-5 %"),
        },
        2.0,
        0.45,
    ),
    "nema17-2A-long": _as_sold(
        "17HS19-2004S1",
        "42 x 48 mm",
        holding_Nm=0.59,
        rated_A=2.0,
        torque_constant_Nm_per_A=0.209,
        inertia_kg_m2=8.2e-6,
        viscous_Nm_s_per_rad=(0.0021, 4.0e-5),
        phase_resistance_ohm=1.4,
        phase_inductance_H=3.0e-3,
        detent_torque_Nm=0.02,
        coulomb_torque_Nm=0.008,
    ),
    "nema23-2.8A": _as_sold(
        "23HS22-2804S",
        "57 x 56 mm",
        holding_Nm=1.26,
        rated_A=2.8,
        torque_constant_Nm_per_A=0.318,
        inertia_kg_m2=3.0e-5,
        viscous_Nm_s_per_rad=(0.0059, 1.0e-4),
        phase_resistance_ohm=0.9,
        phase_inductance_H=2.5e-3,
        detent_torque_Nm=0.042,
        coulomb_torque_Nm=0.02,
    ),
    "nema17-0.33A": _as_sold(
        "SM-42BYG011-25",
        "42 x 34 mm, coils for 12 V",
        holding_Nm=0.23,
        rated_A=0.33,
        torque_constant_Nm_per_A=0.48,
        inertia_kg_m2=3.5e-6,
        viscous_Nm_s_per_rad=(0.0009, 4.0e-5),
        phase_resistance_ohm=34.0,
        phase_inductance_H=46e-3,
        detent_torque_Nm=0.0077,
        coulomb_torque_Nm=0.004,
    ),
    **{name: _of_row(name, row) for name, row in _ROWS.items()},
}


def own_figures(motor: str, plant: str) -> dict[str, float]:
    """Numbers of a motor itself under a plant, without those around it, as its supply."""
    return {
        name: figure.value if figure.full is None or plant != "full" else figure.full
        for name, figure in MOTORS[motor].figures.items()
        if name not in _AROUND
    }


def motor_lines() -> Iterator[str]:
    """List the motors, a line each: the name, what it is, coils and rotor."""
    for name, motor in MOTORS.items():
        of = own_figures(name, "full")
        coils = f"{of['phase_resistance_ohm']:g} ohm, {of['phase_inductance_H'] * 1e3:g} mH"
        yield f"{name:18} {motor.title}; {coils}, rotor {of['inertia_kg_m2'] * 1e7:g} g cm2"


def motor_parameters(motor: str, own: Mapping[str, object]) -> dict[str, object]:
    """Make the parameters of an axis with this motor, as ``profile.yaml`` would write them. ``own`` are those
    that it writes; of one that comes with the motor it may leave out what stays: unit, limits, meaning."""
    written = {name: _written(name, own.get(name, {})) for name in MOTORS[motor].figures}
    for name, figure in MOTORS[motor].figures.items():
        if name not in own:
            full = {} if figure.full is None else {"full": figure.full}
            written[name] |= {"value": figure.value, **full, "source": figure.source}
    return {**written, **{name: given for name, given in own.items() if name not in written}}


def _written(name: str, given: object) -> Any:
    return MEANINGS[name] | dict(given) if isinstance(given, Mapping) else given
