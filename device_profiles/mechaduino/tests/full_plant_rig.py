"""Axis with ``plant: full`` and the Mechaduino's parameters, without a firmware."""

from array import array

from hil.compose import find_catalogue
from hil.core import Core, Snapshot
from hil.vocab.axis_plan import AxisPlan, Load

PROFILE = find_catalogue().profiles["mechaduino"]
FULL = {name: parameter.default("full") for name, parameter in PROFILE.axis.items()}
NO_ERRORS = {
    "full_step_error_pct": 0.0,
    "encoder_eccentricity_deg": 0.0,
    "encoder_nonlinearity_deg": 0.0,
    "encoder_noise_counts": 0.0,
}
IDENTITY = array("f", [i * 360 / 16384 for i in range(16384)]).tobytes()
STEP_DEG = 1.8
TWO_AMPERES = 232  # counts: 2.0016 A


class Rig:
    """An axis without firmware, with an identity table; times in ns since its opening."""

    def __init__(self, load: Load | None = None, seed: int = 0, **parameters: float) -> None:
        self.core = Core(1)
        self.group = self.core.native.group_open(0)
        plan = AxisPlan(FULL | NO_ERRORS | parameters, "full", load or Load(), seed, law="mechaduino")
        self.axis = self.core.open_axis(self.group, plan)
        self.axis.write_table(IDENTITY)
        self.now_ns = 0

    def run(self, duration_ns: float) -> None:
        self.run_to(self.now_ns + round(duration_ns))

    def run_to(self, at_ns: int) -> None:
        self.now_ns = at_ns
        self.core.native.advance(self.group, 2**62, at_ns)

    def run_ms(self, duration_ms: float) -> Snapshot:
        self.run(duration_ms * 1e6)
        return self.axis.snapshot()

    def torque_mode(self, counts: float) -> None:
        self.axis.set("mode", ord("t"))
        self.axis.set("r", counts)
        self.axis.loop(True)

    @property
    def deg(self) -> float:
        return self.axis.get("position_deg")
