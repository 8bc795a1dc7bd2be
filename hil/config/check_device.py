"""Checks of a configuration's device against its profile; what the models can tell is left to them."""

from collections.abc import Mapping
from typing import Any, TypeGuard

from pydantic import BaseModel, ValidationError

from hil.config.catalogue import HardwareVersion, ProfileInfo
from hil.config.check_ports import DEFAULT_PORT, PortsCheck
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import findings_of, no_such, shown, unknown_key
from hil.config.shaft_load import LOAD_KINDS, EndStopsLoad
from hil.vocab.axis_plan import FULL_PARAMETERS
from hil.vocab.firmware import NETWORK
from hil.vocab.ports import port_label

SUPPLY = "supply_V"
"""Axis parameter that the hardware version's supply range applies to."""

EMULATED_KEYS = (
    "network",
    "flash",
    "hardware",
    "plant",
    "load",
    "axis",
    "registers",
    "setpoints",
    "spi_previous_command",
)
REAL_BAUD = 115200
"""Baud of an adapter to a board whose profile has none (USB)."""
START = "start_deg"
"""Axis parameter that end stops must leave room for."""


class DeviceCheck:
    """Check of one device's mapping. ``completed`` has the defaults that its profile gives, ``findings`` the
    mistakes; ``profile`` is None if there is none of its name."""

    def __init__(
        self,
        name: str,
        raw: dict[str, Any],
        document: Document,
        profiles: Mapping[str, ProfileInfo],
        ports: PortsCheck,
    ) -> None:
        self.path: KeyPath = ("devices", name)
        self.raw = raw
        self.document = document
        self.findings: list[Finding] = []
        self.profile = self._profile(profiles)
        self.completed = self._completed(ports)

    def _completed(self, ports: PortsCheck) -> dict[str, Any]:
        result = dict(self.raw)
        for key, given in (("port", self.raw.get("port", DEFAULT_PORT)), (NETWORK, self.raw.get(NETWORK))):
            if given is not None or key == "port":
                result[key] = ports.read(port_label(str(self.path[-1]), key), (*self.path, key), given)
        result.setdefault("hardware", "")
        profile = self.profile
        if profile is None:
            self._load(result, None)
        elif self.raw.get("at") is not None:
            self._real(profile, result)
        else:
            result["hardware"] = self.raw.get("hardware", profile.default_hardware)
            result.setdefault("plant", profile.plant)
            result.setdefault("baud", profile.baud)
            if profile.network_baud is None and self.raw.get(NETWORK) is not None:
                message = f"a {profile.name} has no second serial interface"
                self._add(message, "leave this key out", NETWORK, at_key=True)
            if self.raw.get(key := "setpoint_rate_Hz") is not None:
                self._add("a twin's set-point moves at each step", "leave this key out", key, at_key=True)
            self._axis(profile)
            self._plant(result["plant"], profile)
            self._load(result, profile)
            self._hardware(profile, result["hardware"], result["plant"])
            self._registers(profile)
        return result

    def _real(self, profile: ProfileInfo, result: dict[str, Any]) -> None:
        """Check a real board, which has its own memory, motor and network."""
        for key in EMULATED_KEYS:
            if self.raw.get(key) is not None:
                message = f"a real board (at: {self.raw['at']}) has its own"
                self._add(message, "leave this key out, or leave out at", key, at_key=True)
            result.pop(key, None)
        result["hardware"] = profile.default_hardware
        result.setdefault("baud", profile.baud or REAL_BAUD)

    def _profile(self, profiles: Mapping[str, ProfileInfo]) -> ProfileInfo | None:
        name = self.raw.get("profile")
        if not isinstance(name, str):
            return None
        profile = profiles.get(name)
        if profile is None:
            self._unknown("profile", "profile", name, profiles)
        return profile

    def _unknown(self, key: str, what: str, name: str, known: Mapping[str, object]) -> None:
        self.findings.append(no_such((*self.path, *key.split(".")), what, name, known))

    def _add(self, message: str, remedy: str, *keys: str, at_key: bool = False) -> None:
        self.findings.append(Finding((*self.path, *keys), message, remedy, at_key))

    def _axis(self, profile: ProfileInfo) -> None:
        given = self.raw.get("axis")
        if not isinstance(given, dict):
            return
        for name, value in given.items():
            parameter = profile.axis.get(name)
            if parameter is None:
                self.findings.append(unknown_key((*self.path, "axis", name), profile.axis, given))
            elif _is_number(value) and (refusal := parameter.refusal(value)):
                self._add(*refusal, "axis", name)

    def _plant(self, plant: object, profile: ProfileInfo) -> None:
        missing = [name for name in FULL_PARAMETERS if name not in profile.axis]
        if plant == "full" and missing:
            message = f"profile {profile.name} has no {missing[0]}, which the full plant needs"
            self._add(message, "write plant: simple", "plant")

    def _load(self, result: dict[str, Any], profile: ProfileInfo | None) -> None:
        """Check the load by its kind's own model, so that problems have the file's key paths."""
        given = self.raw.get("load")
        if given is None:
            return
        result["load"] = None
        kinds = f"known kinds are: {', '.join(LOAD_KINDS)}"
        if not isinstance(given, dict):
            self._add(f"a load's kind and numbers are wanted here, not {shown(given)}", kinds, "load")
            return
        kind = given.get("kind")
        if kind is None:
            self._add("the load has no kind", kinds, "load")
        elif not isinstance(kind, str) or kind not in LOAD_KINDS:
            self._unknown("load.kind", "kind of load", str(kind), LOAD_KINDS)
        elif profile and result["plant"] != "full":
            self._add("the simple plant turns nothing but load_torque_Nm", "write plant: full", "load")
        else:
            model = LOAD_KINDS[kind]
            try:
                result["load"] = model.model_validate(given)
            except ValidationError as error:
                self.findings += findings_of(error, model, (*self.path, "load"), self.document)
                return
            if profile:
                self._start_between_stops(result["load"], profile)

    def _start_between_stops(self, load: BaseModel, profile: ProfileInfo) -> None:
        axis = self.raw.get("axis")
        start_deg = axis.get(START) if isinstance(axis, dict) else None
        if start_deg is None and START in profile.axis:
            start_deg = profile.axis[START].default("full")
        if not isinstance(load, EndStopsLoad) or not _is_number(start_deg):
            return
        if not load.min_deg <= start_deg <= load.max_deg:
            remedy = f"write stops around {start_deg:g}, or another axis.{START}"
            self._add(f"the shaft starts outside the stops, at {start_deg:g} deg", remedy, "load")

    def _hardware(self, profile: ProfileInfo, name: object, plant: object) -> None:
        if not isinstance(name, str):
            return
        version = profile.hardware.get(name)
        if version is None:
            self._unknown("hardware", "hardware version", name, profile.hardware)
            return
        axis = self.raw.get("axis")
        own = axis if isinstance(axis, dict) and SUPPLY in axis else None
        default = profile.axis[SUPPLY].default(str(plant)) if SUPPLY in profile.axis else None
        given = own[SUPPLY] if own else default
        if not _is_number(given) or _supplied(version, given):
            return
        message = f"{given:g} V is outside the supply range of {profile.name} {name}"
        choices = [f"write {version.supply_min_V:g} to {version.supply_max_V:g}"]
        choices += [f'hardware: "{other}"' for other, v in profile.hardware.items() if _supplied(v, given)]
        self._add(message, ", or ".join(choices), *(("axis", SUPPLY) if own else ("hardware",)))

    def _registers(self, profile: ProfileInfo) -> None:
        given = self.raw.get("registers")
        if not isinstance(given, dict):
            return
        for name in given:
            if name not in profile.registers:
                self.findings.append(unknown_key((*self.path, "registers", name), profile.registers, given))


def _supplied(version: HardwareVersion, supply_volts: float) -> bool:
    return version.supply_min_V <= supply_volts <= version.supply_max_V


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)
