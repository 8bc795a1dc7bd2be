"""Speed of an EasyDriver's motor raised until it stalls."""

from hil.testing import Bench
from hil.wire.step_dir import generate

LOST_STEPS = 2.5
"""Full steps behind its currents at which a rotor has lost them: they pull it the other way."""


def config(supply_V: float, inductance_H: float, current_A: float, **axis: float) -> dict[str, object]:
    numbers = {"supply_V": supply_V, "phase_inductance_H": inductance_H, "phase_current_A": current_A, **axis}
    return {"bench": "t", "devices": {"d1": {"profile": "easydriver", "hardware": "3V3", "axis": numbers}}}


def stall(supply_V: float, inductance_H: float, current_A: float, *, load: float, **axis: float) -> float:
    """Full steps a second at which the motor stalls, by those of the formula V / (2 L I): up to three times.

    It turns in eighth steps against ``load``, a part of what it holds, and reaches the formula's rate
    in 0.5 s.
    """
    full_Hz = supply_V / (2 * inductance_H * current_A)
    with Bench(config(supply_V, inductance_H, current_A, **axis)) as bench:
        holding_Nm = bench.axis("d1")._axis.holding_Nm
        for part in range(1, 11):
            bench.axis("d1").load_torque_Nm = -load * holding_Nm * part / 10
            bench.run(ms=10)
        bench.run(ms=40)
        lags = bench.axis("d1").record("lag_steps")
        rate_Hz, ramp_s = 3 * 8 * full_Hz, 1.5
        bench.device("d1").drive(generate(-int(rate_Hz * ramp_s), rate_Hz, rate_Hz / ramp_s))
        bench.run(ms=ramp_s * 1e3)
        start_ns = lags.rows[0][0]
        lost_ns = next((at_ns for at_ns, lag in lags.rows if abs(lag) > LOST_STEPS), None)
        assert lost_ns is not None, "it does not stall"
        return 3 * (lost_ns - start_ns) * 1e-9 / ramp_s
