"""Checks of a configuration's motors and loads, of devices whose keys are good."""

from collections.abc import Collection, Iterator

from hil.config.catalogue import Catalogue
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown
from hil.config.model import BenchConfig
from hil.config.motor_bounds import numbers_beyond, pulls_beyond
from hil.config.motor_feed import unfed
from hil.config.shaft_load import ConstantLoad
from hil.core.kinds import KINDS
from hil.sim.load_limit import load_problem
from hil.vocab.address import Address, DeviceParts, address_of
from hil.vocab.axis_plan import AxisPlan

LOAD = "load_torque_Nm"


def motor_findings(
    config: BenchConfig, catalogue: Catalogue, spoilt: Collection[object] = ()
) -> Iterator[Finding]:
    """Findings of motors that the core would not open, and of loads that the bench would not take.
    ``spoilt``: devices that have findings already."""
    motors = {
        Address(name, axis): (device, plan)
        for name, device in config.twins.items()
        if name not in spoilt
        for axis, plan in device.axis_plans(catalogue.profiles[device.profile], 0).items()
        if KINDS[plan.law].has_motor
    }
    refused = catalogue.refused_motors({str(at): plan for at, (_, plan) in motors.items()})
    for at, (device, plan) in motors.items():
        profile = catalogue.profiles[device.profile]
        path: KeyPath = ("devices", at.owner, "axes", at.part)
        if at.part not in device.axes:  # the axis's keys are the device's own, or the profile's
            path = ("devices", at.owner)
        load = device.axis_config(profile, at.part).load
        yield from (
            Finding((*path, *key), what, remedy) for key, what, remedy in unfed(device, profile, at.part)
        )
        beyond = [*numbers_beyond(plan, device.usual_parameters(profile, at.part))]
        yield from (Finding((*path, *key), what, remedy) for key, what, remedy in beyond)
        if beyond:  # what follows is reckoned with these numbers
            continue
        if str(at) in refused:
            what, _, remedy = refused[str(at)].partition(": ")
            yield Finding((*path, "axis"), what, remedy)
        yield from _load_findings(config, at, (*path, "axis", LOAD), plan, DeviceParts(profile.axes))
        if isinstance(load, ConstantLoad) and (problem := load_problem(load.torque_Nm, _holding_Nm(plan))):
            yield _refused((*path, "load", "torque_Nm"), load.torque_Nm, problem)
        elif load:
            yield from (Finding((*path, "load"), *pull) for pull in pulls_beyond(plan))


def _load_findings(
    config: BenchConfig, at: Address, path: KeyPath, plan: AxisPlan, axes: DeviceParts[object]
) -> Iterator[Finding]:
    """Findings of an axis's own load, then of those of the faults: each beside all before it."""
    loads: list[tuple[KeyPath, float]] = [(path, plan.parameters[LOAD])]
    for index, fault in enumerate(config.faults):
        target = address_of(fault.target)
        is_here = target.owner == at.owner and (len(axes) == 1 or (target.part or axes.first) == at.part)
        if fault.fault == "shaft_load" and is_here:
            loads.append((("faults", index, "torque_Nm"), (fault.model_extra or {})["torque_Nm"]))
    before_Nm: list[float] = []
    for path, torque_Nm in loads:
        if problem := load_problem(torque_Nm, _holding_Nm(plan), before_Nm):
            yield _refused(path, torque_Nm, problem)
        before_Nm.append(torque_Nm)


def _holding_Nm(plan: AxisPlan) -> float:
    return KINDS[plan.law].holding_Nm(plan.parameters)


def _refused(path: KeyPath, torque_Nm: float, problem: str) -> Finding:
    return Finding(path, f"{shown(torque_Nm)} is not allowed here", problem)
