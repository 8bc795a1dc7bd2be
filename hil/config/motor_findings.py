"""Checks of a configuration's motors and loads, once all keys are good."""

from collections.abc import Iterator

from hil.config.catalogue import Catalogue
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown
from hil.config.model import BenchConfig
from hil.config.shaft_load import ConstantLoad
from hil.sim.load_limit import load_problem
from hil.vocab.axis_plan import AxisPlan

LOAD = "load_torque_Nm"


def motor_findings(config: BenchConfig, catalogue: Catalogue) -> Iterator[Finding]:
    """Findings of motors that the core would not open, and of loads that the bench would not take."""
    plans = {
        name: device.axis_plan(catalogue.profiles[device.profile], 0) for name, device in config.twins.items()
    }
    refused = catalogue.refused_motors(plans)
    for name, plan in plans.items():
        device = config.devices[name]
        if name in refused:
            what, _, remedy = refused[name].partition(": ")
            yield Finding(("devices", name, "axis"), what, remedy)
        yield from _load_findings(config, name, plan)
        torque_Nm = device.load.torque_Nm if isinstance(device.load, ConstantLoad) else 0.0
        if problem := load_problem(torque_Nm, plan.holding_Nm):
            yield _refused(("devices", name, "load", "torque_Nm"), torque_Nm, problem)


def _load_findings(config: BenchConfig, name: str, plan: AxisPlan) -> Iterator[Finding]:
    """Findings of a device's own load, then of those of the faults: each beside all before it."""
    loads: list[tuple[KeyPath, float]] = [(("devices", name, "axis", LOAD), plan.parameters[LOAD])]
    for index, fault in enumerate(config.faults):
        if fault.fault == "shaft_load" and fault.target.partition(".")[0] == name:
            loads.append((("faults", index, "torque_Nm"), (fault.model_extra or {})["torque_Nm"]))
    before_Nm: list[float] = []
    for path, torque_Nm in loads:
        if problem := load_problem(torque_Nm, plan.holding_Nm, before_Nm):
            yield _refused(path, torque_Nm, problem)
        before_Nm.append(torque_Nm)


def _refused(path: KeyPath, torque_Nm: float, problem: str) -> Finding:
    return Finding(path, f"{shown(torque_Nm)} is not allowed here", problem)
