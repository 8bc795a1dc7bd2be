"""Checks of one axis of a configuration's device against its profile."""

from collections.abc import Mapping
from typing import Any, TypeGuard

from pydantic import BaseModel, ValidationError

from hil.config.board_numbers import HardwareVersion
from hil.config.catalogue import AxisInfo, ProfileInfo
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import findings_of, no_such, shown, unknown_key
from hil.config.motors import MOTORS
from hil.config.shaft_load import LOAD_KINDS, EndStopsLoad
from hil.core.kinds import KINDS
from hil.vocab.axis_plan import FULL_PARAMETERS

SUPPLY = "supply_V"
"""Axis parameter that the hardware version's supply range applies to."""
START = "start_deg"
"""Axis parameter that end stops must leave room for."""
AXIS_KEYS = ("plant", "motor", "load", "axis", "registers")
"""Keys of an axis; those of a device are of its first one."""


class AxisCheck:
    """Check of the keys of an axis in one mapping: a device's, or one of its ``axes``. ``load`` is the load
    as its model, None where there is none or it has a finding."""

    def __init__(self, path: KeyPath, raw: Mapping[str, Any], plant: object, document: Document) -> None:
        self.path = path
        self.raw = raw
        self.plant = plant
        self.document = document
        self.findings: list[Finding] = []
        self.load: BaseModel | None = None

    def check(self, profile: ProfileInfo, info: AxisInfo, hardware: object) -> None:
        """Check all keys. ``hardware``: the device's version."""
        if info.law in KINDS and not KINDS[info.law].has_motor:
            why = f"profile {profile.name} has no motor"
            given = {key: self.raw.get(key) for key in AXIS_KEYS if key != "registers" or not info.registers}
            places = [(*self.path, key) for key, value in given.items() if value and value != "simple"]
            self.findings += [Finding(place, why, "leave this key out", at_key=True) for place in places]
            if info.registers:
                self._registers(info)
            return
        self._parameters(info)
        self._plant(profile, info)
        self._motor()
        self.check_load(info)
        if isinstance(hardware, str) and hardware in profile.hardware:
            self._supply(profile, info, hardware)
        self._registers(info)

    def _add(self, message: str, remedy: str, *keys: str) -> None:
        self.findings.append(Finding((*self.path, *keys), message, remedy))

    def _parameters(self, info: AxisInfo) -> None:
        given = self.raw.get("axis")
        if not isinstance(given, dict):
            return
        for name, value in given.items():
            parameter = info.axis.get(name)
            if parameter is None:
                self.findings.append(unknown_key((*self.path, "axis", name), info.axis, given))
            elif _is_number(value) and (refusal := parameter.refusal(value)):
                self._add(*refusal, "axis", name)

    def _plant(self, profile: ProfileInfo, info: AxisInfo) -> None:
        missing = [name for name in FULL_PARAMETERS if name not in info.axis]
        if self.plant == "full" and missing:
            message = f"profile {profile.name} has no {missing[0]}, which the full plant needs"
            self._add(message, "write plant: simple", "plant")

    def _motor(self) -> None:
        motor = self.raw.get("motor")
        if isinstance(motor, str) and motor not in MOTORS:
            self.findings.append(no_such((*self.path, "motor"), "motor", motor, MOTORS))

    def check_load(self, info: AxisInfo | None) -> None:
        """Check the load by its kind's own model, so that problems have the file's key paths. ``info``: None
        if nobody knows the axis."""
        given = self.raw.get("load")
        if given is None:
            return
        kinds = f"known kinds are: {', '.join(LOAD_KINDS)}"
        if not isinstance(given, dict):
            self._add(f"a load's kind and numbers are wanted here, not {shown(given)}", kinds, "load")
            return
        kind = given.get("kind")
        if kind is None:
            self._add("the load has no kind", f"add kind: and one of {', '.join(LOAD_KINDS)}", "load")
        elif not isinstance(kind, str) or kind not in LOAD_KINDS:
            self.findings.append(no_such((*self.path, "load", "kind"), "kind of load", str(kind), LOAD_KINDS))
        elif info and self.plant != "full":
            self._add("the simple plant turns nothing but load_torque_Nm", "write plant: full", "load")
        else:
            model = LOAD_KINDS[kind]
            try:
                self.load = model.model_validate(given)
            except ValidationError as error:
                self.findings += findings_of(error, model, (*self.path, "load"), self.document)
                return
            if info:
                self._start_between_stops(self.load, info)

    def _start_between_stops(self, load: BaseModel, info: AxisInfo) -> None:
        axis = self.raw.get("axis")
        start_deg = axis.get(START) if isinstance(axis, dict) else None
        if start_deg is None and START in info.axis:
            start_deg = info.axis[START].default("full")
        if not isinstance(load, EndStopsLoad) or not _is_number(start_deg):
            return
        if not load.min_deg <= start_deg <= load.max_deg:
            remedy = f"write stops around {start_deg:g}, or another axis.{START}"
            self._add(f"the shaft starts outside the stops, at {start_deg:g} deg", remedy, "load")

    def _supply(self, profile: ProfileInfo, info: AxisInfo, hardware: str) -> None:
        axis = self.raw.get("axis")
        own = axis if isinstance(axis, dict) and SUPPLY in axis else None
        default = info.axis[SUPPLY].default(str(self.plant)) if SUPPLY in info.axis else None
        given = own[SUPPLY] if own else default
        if not _is_number(given) or _supplied(profile.hardware[hardware], given):
            return
        version = profile.hardware[hardware]
        message = f"{given:g} V is outside the supply range of {profile.name} {hardware}"
        choices = [f"write {version.supply_min_V:g} to {version.supply_max_V:g}"]
        choices += [f'hardware: "{other}"' for other, v in profile.hardware.items() if _supplied(v, given)]
        place = (*self.path, "axis", SUPPLY) if own else (*self.path[:2], "hardware")
        self.findings.append(Finding(place, message, ", or ".join(choices)))

    def _registers(self, info: AxisInfo) -> None:
        given = self.raw.get("registers")
        if not isinstance(given, dict):
            return
        for name in given:
            if name not in info.registers:
                self.findings.append(unknown_key((*self.path, "registers", name), info.registers, given))


def _supplied(version: HardwareVersion, supply_volts: float) -> bool:
    return version.supply_min_V <= supply_volts <= version.supply_max_V


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)
