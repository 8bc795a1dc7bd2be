"""From text or a mapping to a validated bench, with every problem found at once."""

import difflib
import json
import posixpath
from collections.abc import Iterator, Mapping
from typing import Any, TypeGuard

from pydantic import BaseModel, ValidationError

from hil.config.bridges import read_bridges
from hil.config.catalogue import Catalogue, HardwareVersion, ProfileInfo
from hil.config.document import Document, Finding, KeyPath, document_from_mapping
from hil.config.explain import findings_of, nearest, shown, unknown_key
from hil.config.faults import fault_findings
from hil.config.load import LOAD_KINDS, EndStopsLoad
from hil.config.model import BenchConfig, PortConfig
from hil.config.motors import motor_findings
from hil.config.segments import segment_findings
from hil.config.wires import wire_findings
from hil.config.yaml_text import document_from_yaml
from hil.vocab.axis_plan import FULL_PARAMETERS
from hil.vocab.firmware import NETWORK
from hil.vocab.ports import port_label

DEFAULT_PORT = "pty"
SUPPLY = "supply_V"
"""The axis parameter that the hardware version's supply range applies to."""

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
"""Of an adapter to a board whose profile has none (USB)."""
START = "start_deg"
"""The axis parameter that end stops must leave room for."""


class _NoOptions(BaseModel):
    """Stands in for the options of a port that has a finding."""


def parse(text: str, file: str, catalogue: Catalogue) -> BenchConfig:
    """Read a bench's YAML. ``file`` is the name that problems carry; nothing is opened.

    Raises:
        ConfigError: with all problems, in file order.
    """
    document = document_from_yaml(text, file)
    if document.value is None and not document.findings:
        remedy = 'begin with "bench: NAME" and "devices:"'
        raise document.error([Finding((), "the file is empty", remedy)])
    return _check(document, catalogue)


def from_dict(data: Mapping[str, object], catalogue: Catalogue) -> BenchConfig:
    """The same bench from Python data, with the same checks; problems have line 0.

    Raises:
        ConfigError: with all problems.
    """
    return _check(document_from_mapping(data, "<dict>"), catalogue)


def _check(document: Document, catalogue: Catalogue) -> BenchConfig:
    findings = list(document.findings)
    config: BenchConfig | None = None
    value: Any = document.value
    runtime_dir: object = None
    ports: dict[tuple[str, str], PortConfig] = {}
    profiles: dict[str, ProfileInfo] = {}
    if isinstance(value, dict) and isinstance(value.get("devices"), dict):
        devices = dict(value["devices"])
        for name, raw in devices.items():
            if isinstance(raw, dict):
                device = _Device(("devices", name), raw, document, catalogue)
                devices[name] = device.completed()
                findings += device.findings
                ports |= {(name, key): port for key, port in device.ports.items()}
                if device.profile is not None:
                    profiles[name] = device.profile
        value = {**value, "devices": devices}
        if isinstance(value.get("segments"), dict):
            segments = _Segments(value["segments"], document, catalogue)
            value["segments"] = segments.completed
            findings += segments.findings
            ports |= segments.ports
        if isinstance(value.get("bridges"), dict):
            value["bridges"], wrong = read_bridges(value["bridges"], catalogue.bridges, document)
            findings += wrong
        runtime_dir = value.get("runtime_dir")
    try:
        config = BenchConfig.model_validate(value)
    except ValidationError as error:
        findings += findings_of(error, BenchConfig, (), document)
    findings += _clashes(ports, runtime_dir)
    if profiles and len(profiles) == len(value["devices"]):
        real = {name for name, raw in value["devices"].items() if raw.get("at") is not None}
        full = {name for name, raw in value["devices"].items() if raw.get("plant") == "full"} - real
        findings += wire_findings(value.get("wires"), profiles, real)
        findings += segment_findings(value.get("segments"), profiles, real)
        findings += fault_findings(value.get("faults"), value.get("segments"), profiles, real, full)
        findings += _same_at(value["devices"])
    if config is not None and not findings:
        findings += motor_findings(config, catalogue)
    if config is None or findings:
        raise document.error(findings)
    return config


def _same_at(devices: Mapping[str, Mapping[str, object]]) -> Iterator[Finding]:
    """Real boards at a port that another one has."""
    taken: dict[str, str] = {}
    for name, raw in devices.items():
        if isinstance(at := raw.get("at"), str) and taken.setdefault(at, name) != name:
            yield Finding(
                ("devices", name, "at"), f"device {taken[at]} is there", "each board has its own port"
            )


class _Segments:
    """The segments with their taps' ports against the catalogue."""

    def __init__(self, raw: dict[str, Any], document: Document, catalogue: Catalogue) -> None:
        self.completed: dict[str, Any] = dict(raw)
        self.findings: list[Finding] = []
        self.ports: dict[tuple[str, str], PortConfig] = {}
        for name, segment in raw.items():
            taps = segment.get("taps") if isinstance(segment, dict) else None
            if not isinstance(taps, dict):
                continue
            done = dict(taps)
            for tap, keys in taps.items():
                if not isinstance(keys, dict):
                    continue
                reader = _Device(("segments", name, "taps", tap), keys, document, catalogue)
                port = reader.read_port(keys.get("port", DEFAULT_PORT), "port")
                done[tap] = {"real": port.kind == "serial", **keys, "port": port}
                self.findings += reader.findings
                self.ports |= {(f"{name}.{tap}", key): port for key, port in reader.ports.items()}
            self.completed[name] = {**segment, "taps": done}


class _Device:
    """One device's mapping against the catalogue; what the models alone can tell is left to them."""

    def __init__(self, path: KeyPath, raw: dict[str, Any], document: Document, catalogue: Catalogue) -> None:
        self.path = path
        self.raw = raw
        self.document = document
        self.catalogue = catalogue
        self.findings: list[Finding] = []
        self.ports: dict[str, PortConfig] = {}
        """By their keys: port, network."""
        self.profile: ProfileInfo | None = None

    def completed(self) -> dict[str, Any]:
        """The mapping with the defaults that the catalogue gives."""
        result = dict(self.raw)
        result["port"] = self.read_port(self.raw.get("port", DEFAULT_PORT), "port")
        if self.raw.get(NETWORK) is not None:
            result[NETWORK] = self.read_port(self.raw[NETWORK], NETWORK)
        result.setdefault("hardware", "")
        profile = self.profile = self._profile()
        if profile is not None and self.raw.get("at") is not None:
            self._real(profile, result)
        elif profile is not None:
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
        """A real board has its own memory, motor and network."""
        for key in EMULATED_KEYS:
            if self.raw.get(key) is not None:
                message = f"a real board (at: {self.raw['at']}) has its own"
                self._add(message, "leave this key out, or leave out at", key, at_key=True)
            result.pop(key, None)
        result["hardware"] = profile.default_hardware
        result.setdefault("baud", profile.baud or REAL_BAUD)

    def _profile(self) -> ProfileInfo | None:
        name = self.raw.get("profile")
        if not isinstance(name, str):
            return None
        profile = self.catalogue.profiles.get(name)
        if profile is None:
            self._unknown("profile", "profile", name, self.catalogue.profiles)
        return profile

    def _unknown(self, key: str, what: str, name: str, known: Mapping[str, object]) -> None:
        near = nearest(name, known)
        meant = f'did you mean "{near}"? ' if near else ""
        remedy = f"{meant}known are: {', '.join(sorted(known)) or 'none'}"
        self._add(f"there is no {what} {shown(name)}", remedy, *key.split("."))

    def _add(self, message: str, remedy: str, *keys: str, at_key: bool = False) -> None:
        self.findings.append(Finding((*self.path, *keys), message, remedy, at_key))

    def read_port(self, value: object, key: str) -> PortConfig:
        """A port as it is configured under a key."""
        port = self._read_port(value, key)
        if port is not None:
            self.ports[key] = port
        # After a finding the value no longer matters, but it must not raise a second one.
        return port or PortConfig(kind="", options=_NoOptions())

    def _read_port(self, value: object, key: str) -> PortConfig | None:
        if isinstance(value, str):
            return self._options(value, {}, key, key)
        kinds = f"known kinds are: {', '.join(sorted(self.catalogue.ports)) or 'none'}"
        wanted = "the name of a kind of port is wanted here"
        if not isinstance(value, dict):
            self._add(f"{wanted}, or its options, not {shown(value)}", kinds, key)
            return None
        options = dict(value)
        kind = options.pop("kind", None)
        if isinstance(kind, str):
            return self._options(kind, options, key, f"{key}.kind")
        if "kind" in value:
            self._add(f"{wanted}, not {shown(kind)}", kinds, key, "kind")
        elif close := difflib.get_close_matches("kind", value, n=1):
            self._add("unknown key", 'did you mean "kind"?', key, close[0], at_key=True)
        else:
            self._add("this key is missing", 'say which kind of port, as in "kind: pty"', key, "kind")
        return None

    def _options(
        self, kind: str, options: dict[str, object], port_key: str, kind_key: str
    ) -> PortConfig | None:
        model = self.catalogue.ports.get(kind)
        if model is None:
            self._unknown(kind_key, "kind of port", kind, self.catalogue.ports)
            return None
        path = (*self.path, port_key)
        known = [field.alias or name for name, field in model.model_fields.items()]
        for key in options:
            if key not in known:
                self.findings.append(unknown_key((*path, key), ["kind", *known], {"kind", *options}))
        mine = json.dumps({key: value for key, value in options.items() if key in known})
        try:
            # As JSON, so that strict still reads a path or an enumeration from text.
            return PortConfig(kind=kind, options=model.model_validate_json(mine, strict=True))
        except ValidationError as error:
            unknown = {f.remedy for f in self.findings if f.path[:-1] == path}
            self.findings += [
                finding
                for finding in findings_of(error, model, path, self.document)
                if f'did you mean "{finding.path[-1]}"?' not in unknown
            ]
            return None

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

    def _load(self, result: dict[str, Any], profile: ProfileInfo) -> None:
        """Checks the load by its kind's own model, so that problems have the file's key paths."""
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
        elif result["plant"] != "full":
            self._add("the simple plant turns nothing but load_torque_Nm", "write plant: full", "load")
        else:
            model = LOAD_KINDS[kind]
            try:
                result["load"] = model.model_validate(given)
            except ValidationError as error:
                self.findings += findings_of(error, model, (*self.path, "load"), self.document)
                return
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
        message = f"{given:g} V is outside the supply range of {profile.name} {version.name}"
        choices = [f"write {version.supply_min_V:g} to {version.supply_max_V:g}"]
        choices += [f'hardware: "{v.name}"' for v in profile.hardware.values() if _supplied(v, given)]
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


def _clashes(ports: Mapping[tuple[str, str], PortConfig], runtime_dir: object) -> list[Finding]:
    """Ports in a place that another port has already. ``ports`` by device and key."""
    findings: list[Finding] = []
    taken: dict[tuple[object, ...], str] = {}
    directory = runtime_dir if isinstance(runtime_dir, str) else ""
    for (device, port_key), port in ports.items():
        label = port_label(device, port_key)
        for place, key in _places(label, port.options, directory):
            owner = taken.setdefault(place, label)
            if owner != label:
                where = shown(":".join(map(str, place)))
                message = f"device {owner} has its port in the same place, {where}"
                segment, dot, tap = device.partition(".")
                home = ("segments", segment, "taps", tap) if dot else ("devices", device)
                path = (*home, port_key, key)
                findings.append(Finding(path, message, "give each device a place of its own"))
    return findings


def _places(device: str, options: BaseModel, runtime_dir: str) -> Iterator[tuple[tuple[object, ...], str]]:
    """Where a port is, as its options say, and the option that says so.

    By convention ``path`` is relative to the runtime directory and None stands for the device's
    name there; ``host`` and ``port`` are a listener's address, and port 0 any free one.
    """
    if hasattr(options, "path"):
        path = device if options.path is None else str(options.path)
        yield (posixpath.normpath(posixpath.join(runtime_dir, path)),), "path"
    host, port = getattr(options, "host", None), getattr(options, "port", None)
    if host is not None and port:
        yield (str(host).lower(), port), "port"
