"""An EasyDriver's motor goes faster until it stalls, with three supplies, beside the manual's V / (2 L I).

`python easydriver_stall.py stall.png` draws it (needs the extra `plot`).
"""

import sys
from pathlib import Path

from hil.telemetry import Recording
from hil.testing import Bench
from hil.wire.step_dir import generate

INDUCTANCE_H, CURRENT_A = 0.050, 0.135
SUPPLIES_V = (9, 12, 18)
LOAD = 0.55
"""Load, as a part of what the motor holds: 0.48 Nm/A times its current."""
RAMP_S, TIMES = 1.2, 1.6
"""Time of the sweep, and its end, in units of the formula's rate."""
LOST_STEPS = 2.5
"""Full steps by which a rotor is behind that has lost its field."""


def formula_Hz(supply_V: float) -> float:
    """Full steps a second that the time of a coil's reversal allows."""
    return supply_V / (2 * INDUCTANCE_H * CURRENT_A)


def sweep(supply_V: float) -> Recording:
    """Turn faster and faster, in eighth steps against the load."""
    axis = {"supply_V": supply_V, "phase_inductance_H": INDUCTANCE_H, "phase_current_A": CURRENT_A}
    bench = Bench({"bench": "stall", "devices": {"d1": {"profile": "easydriver", "axis": axis}}})
    for part in range(1, 11):  # at once it would swing past what the motor holds
        bench.axis("d1").load_torque_Nm = -LOAD * 0.48 * CURRENT_A * part / 10
        bench.run(ms=20)
    recording = bench.axis("d1").record("position_deg", "lag_steps")
    rate_Hz = TIMES * 8 * formula_Hz(supply_V)
    bench.device("d1").drive(generate(-int(rate_Hz * RAMP_S), rate_Hz, rate_Hz / RAMP_S))
    bench.run(ms=RAMP_S * 1e3)
    return recording


def commanded_Hz(recording: Recording, supply_V: float) -> list[float]:
    """Full steps a second that are asked for at each sample."""
    return [TIMES * formula_Hz(supply_V) * at_s / RAMP_S for at_s in recording.at_s()]


def stall_Hz(recording: Recording, supply_V: float) -> float:
    """Full steps a second at which the rotor was lost."""
    asked = zip(commanded_Hz(recording, supply_V), recording.column("lag_steps"), strict=True)
    return next(rate_Hz for rate_Hz, lag in asked if abs(lag) > LOST_STEPS)


def draw(recordings: dict[int, Recording], path: Path) -> None:
    """Draw the speed of the shaft over the one that is asked for."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    panel = figure.subplots()
    for number, (supply_V, recording) in enumerate(recordings.items()):
        asked_Hz, deg = commanded_Hz(recording, supply_V), recording.column("position_deg")
        turned_Hz = [(later - earlier) / 1.8 / 0.02 for earlier, later in zip(deg, deg[20:], strict=False)]
        panel.plot(asked_Hz[10:-10], turned_Hz, color=f"C{number}", label=f"{supply_V} V: the shaft")
        panel.axvline(
            formula_Hz(supply_V), color=f"C{number}", linestyle="--", label=f"{supply_V} V: V / (2 L I)"
        )
    panel.set_xlabel("asked for [full steps/s]")
    panel.set_ylabel("turned [full steps/s]")
    panel.set_ylim(-200, None)
    panel.set_title(f"50 mH, 0.135 A, 34 ohm, in eighth steps against {LOAD:.0%} of the holding torque")
    panel.grid(alpha=0.3)
    panel.legend()
    figure.savefig(path, dpi=120)


def main() -> None:
    recordings = {supply_V: sweep(supply_V) for supply_V in SUPPLIES_V}
    for supply_V, recording in recordings.items():
        formula, stalled = formula_Hz(supply_V), stall_Hz(recording, supply_V)
        print(
            f"{supply_V:2} V: by the formula {formula:6.1f} full steps/s,"
            f" it stalls at {stalled:6.1f} ({stalled / formula:.2f} times)"
        )
    if len(sys.argv) > 1:
        draw(recordings, Path(sys.argv[1]))


if __name__ == "__main__":
    main()
