"""Checks of a configuration's device against its profile; checks that the models make are left to them."""

from dataclasses import replace
from typing import Any

from hil.config.board_fields import FIELDS_KEY, start_findings
from hil.config.board_parameters import PARAMETERS_KEY, build_findings
from hil.config.catalogue import Catalogue, ProfileInfo
from hil.config.check_axis import AXIS_KEYS, AxisCheck
from hil.config.check_ports import DEFAULT_PORT, PortsCheck
from hil.config.device_parts_model import BUILT_IN_TABLES
from hil.config.device_program import ProgramCheck
from hil.config.device_sketch import SKETCH, SketchCheck
from hil.config.document import Document, Finding, KeyPath
from hil.config.drive_findings import EMULATED_KEYS, ONLY_OF_DRIVES, drive_findings
from hil.config.explain import no_such, suggestion
from hil.config.real_places import address_finding, kind_at
from hil.vocab.address import Address
from hil.vocab.firmware import NETWORK
from hil.vocab.near_words import nearest
from hil.vocab.problem import Problem

_AT_UARTS = ("at", "port", "network", "ports", "baud", "bauds")
"""Keys that need a serial interface."""
_OF_REAL_BOARDS = {
    "setpoint_rate_Hz": "a twin's set-point moves at each step",
    "line_delay_ms": "a run reaches a twin without a line",
    "poll_interval_ms": "a twin tells its state without being asked",
    "echo": "a twin has no adapter; `echo` of a `serial` port is for one",
}
"""Keys that a twin has no use for, with the reason."""
ANY_BOARDS_TABLES = ("stored", "empty")
"""Tables that the memory of every board can begin with."""
REAL_BAUD = 115200
"""Baud of an adapter to a board whose profile has none (USB)."""


class DeviceCheck:
    """Check of one device's mapping.

    Long because each key has its check in one place. ``completed`` has the defaults that its profile gives,
    ``findings`` the mistakes, ``problems`` those in a file that it names; ``profile`` is None if there is
    none of its name."""

    def __init__(
        self, name: str, raw: dict[str, Any], document: Document, catalogue: Catalogue, ports: PortsCheck
    ) -> None:
        self.name = name
        self.path: KeyPath = ("devices", name)
        self.raw = raw
        self.document = document
        self.findings: list[Finding] = []
        self.problems: list[Problem] = []
        self._catalogue = catalogue
        self.profile = self._profile(catalogue)
        self.board = catalogue.boards.get(self.profile.name) if self.profile else None
        self.completed = self._completed(ports)

    def _completed(self, ports: PortsCheck) -> dict[str, Any]:
        result, profile = dict(self.raw), self.profile
        at = self.raw.get("at")
        kinds = self._catalogue.drive_kinds
        if isinstance(at, str) and (finding := address_finding((*self.path, "at"), at, kinds)):
            self.findings.append(finding)
        is_drive = profile and (self._catalogue.drive_kind(profile) or kind_at(str(at), kinds))
        if profile and isinstance(at, str) and is_drive:
            findings, result = drive_findings(self.path, self.raw, profile, at, result, self._catalogue)
            if "map" in result:
                self._map(result)
            self.findings += findings
            return result
        if profile and not profile.uarts:
            self._no_uarts(profile, result)
        else:
            self._ports(result, ports)
        self._map(result)
        result.setdefault("hardware", "")
        if profile is None:
            self._load_of(result, AxisCheck(self.path, self.raw, None, self.document))
        elif result.get("at") is not None:
            self._real(profile, result)
        else:
            result["hardware"] = self.raw.get("hardware", profile.default_hardware)
            result.setdefault("plant", profile.plant)
            result.setdefault("baud", profile.baud())
            keys = {name: key.of_twins for kind in kinds for name, key in kind.keys.items()}
            for key, why in (_OF_REAL_BOARDS | keys).items():
                if self.raw.get(key) is not None:
                    self._add(why, "leave this key out", key, at_key=True)
            if profile.uarts:
                self._uarts(profile)
            self._axes(profile, result)
            self.findings += start_findings(self.path, self.raw.get(FIELDS_KEY), profile.fields)
            given = self.raw.get(PARAMETERS_KEY)
            self.findings += build_findings(self.path, given, profile.parameters, profile.name)
            self._sketch(profile, result)
            self._hardware(profile, result["hardware"])
            self._table(profile)
            programs = ProgramCheck(self.path, self.raw, self.document, profile, self._catalogue.read_bytes)
            result |= programs.read()
            self.findings += programs.findings
            self.problems += programs.problems
        return result

    def _sketch(self, profile: ProfileInfo, result: dict[str, Any]) -> None:
        """Read the sketch of its user."""
        if (given := self.raw.get(SKETCH)) is not None:
            check = SketchCheck(self.path, given, self.document, self._catalogue.read_text)
            result[SKETCH] = check.read(profile.name, takes=bool(self.board and self.board.sketch))
            self.findings += check.findings
            self.problems += check.problems

    def _map(self, result: dict[str, Any]) -> None:
        """Read the map of the board's own registers."""
        maps = self._catalogue.maps
        if self.raw.get("map") is not None and maps:
            from hil.config.device_map import MapCheck

            check = MapCheck(
                self.path, self.raw, self.document, self.profile, maps, self._catalogue.read_text
            )
            result["map"] = check.read()
            self.findings += check.findings
            self.problems += check.problems

    def _ports(self, result: dict[str, Any], ports: PortsCheck) -> None:
        """Read the ports: ``port``, ``network``, and those of ``ports``."""
        result["port"] = ports.read(self.name, (*self.path, "port"), self.raw.get("port", DEFAULT_PORT))
        if (given := self.raw.get(NETWORK)) is not None:
            result[NETWORK] = ports.read(str(Address(self.name, NETWORK)), (*self.path, NETWORK), given)
        if isinstance(others := self.raw.get("ports"), dict):
            result["ports"] = {
                uart: ports.read(str(Address(self.name, str(uart))), (*self.path, "ports", uart), given)
                for uart, given in others.items()
            }

    def _no_uarts(self, profile: ProfileInfo, result: dict[str, Any]) -> None:
        for key in _AT_UARTS:
            if result.pop(key, None) not in (None, {}):  # as it stands in a log
                self._add(f"a {profile.name} has no serial interface", "leave this key out", key, at_key=True)

    def _uarts(self, profile: ProfileInfo) -> None:
        """Check that the board has the UARTs that ports and speeds are for, and no UART two of them."""
        if NETWORK not in profile.uarts and self.raw.get(NETWORK) is not None:
            message = f"a {profile.name} has no second serial interface"
            if len(profile.uarts) > 1:
                message = f"a {profile.name} has no serial interface {NETWORK!r}"
            self._add(message, "leave this key out", NETWORK, at_key=True)
        known = [name for name in profile.uarts if name != profile.first_uart]
        network = {NETWORK: NETWORK} if self.raw.get(NETWORK) else {}
        for key, others in (("port", network), ("baud", {})):
            has_other, given = {profile.first_uart: key, **others}, self.raw.get(f"{key}s")
            for uart in given if isinstance(given, dict) else ():
                if uart not in profile.uarts:
                    what = f"serial interface of a {profile.name}"
                    self.findings.append(no_such((*self.path, f"{key}s", uart), what, str(uart), known))
                elif uart in has_other:
                    message = f"the {key} of {uart} is the key {has_other[uart]}"
                    self._add(message, "leave one of them out", f"{key}s", uart, at_key=True)

    def _axes(self, profile: ProfileInfo, result: dict[str, Any]) -> None:
        """Check the axes: the first one's keys are the device's own, and may be under its name as well."""
        first = next(iter(profile.axes), None)
        if first is None:
            for key in (*AXIS_KEYS, "axes"):
                if self.raw.get(key) not in (None, {}, "simple"):  # a log writes these defaults out
                    self._add(f"a {profile.name} has no axis", "leave this key out", key, at_key=True)
            result["load"] = None
            return
        own = AxisCheck(self.path, self.raw, result["plant"], self.document)
        own.check(profile, profile.axes[first], result["hardware"])
        self._load_of(result, own)
        given = self.raw.get("axes")
        if not isinstance(given, dict):
            return
        result["axes"] = dict(given)
        for name, raw in given.items():
            if name not in profile.axes:
                what = f"axis of a {profile.name}"
                self.findings.append(no_such((*self.path, "axes", name), what, str(name), profile.axes))
            elif isinstance(raw, dict):
                result["axes"][name] = dict(raw)
                plant = raw.get("plant") or result["plant"]
                each = AxisCheck((*self.path, "axes", name), raw, plant, self.document)
                each.check(profile, profile.axes[name], result["hardware"])
                self._load_of(result["axes"][name], each)

    def _load_of(self, result: dict[str, Any], check: AxisCheck) -> None:
        """Take over an axis's findings, and its load as a model."""
        if self.profile is None:
            check.check_load(None)
        self.findings += check.findings
        if check.raw.get("load") is not None:
            result["load"] = check.load

    def _real(self, profile: ProfileInfo, result: dict[str, Any]) -> None:
        """Check a real board, which has its own memory, motor and network."""
        kinds = self._catalogue.drive_kinds
        keys = {name: key.of_others for kind in kinds for name, key in kind.keys.items()}
        for key, why in (ONLY_OF_DRIVES | keys).items():
            if self.raw.get(key) is not None:
                self._add(why, "leave this key out", key, at_key=True)
        for key in EMULATED_KEYS:
            if self.raw.get(key) is not None:
                message = f"a real board (at: {self.raw['at']}) has its own"
                self._add(message, "leave this key out, or leave out at", key, at_key=True)
            result.pop(key, None)
        result["hardware"] = profile.default_hardware
        result.setdefault("baud", profile.baud() or REAL_BAUD)

    def _profile(self, catalogue: Catalogue) -> ProfileInfo | None:
        name = self.raw.get("profile")
        if not isinstance(name, str):
            return None
        if catalogue.problems(name):
            self._add(f"the board {name} cannot be used", "mend what is said of it below", "profile")
            return None
        profile = catalogue.profiles.get(name)
        if profile is None:
            finding = no_such((*self.path, "profile"), "profile", name, catalogue.profiles)
            if not nearest(name, catalogue.profiles):
                remedy = f"{finding.remedy}; where boards of your own are, profile_path says"
                finding = replace(finding, remedy=remedy)
            self.findings.append(finding)
        return profile

    def _hardware(self, profile: ProfileInfo, name: object) -> None:
        if isinstance(name, str) and name not in profile.hardware:
            self.findings.append(
                no_such((*self.path, "hardware"), "hardware version", name, profile.hardware)
            )

    def _add(self, message: str, remedy: str, *keys: str, at_key: bool = False) -> None:
        self.findings.append(Finding((*self.path, *keys), message, remedy, at_key))

    def _table(self, profile: ProfileInfo) -> None:
        """Check that the board takes the table that its memory is to begin with."""
        flash = self.raw.get("flash")
        table = flash.get("table") if isinstance(flash, dict) else None
        if not isinstance(table, str) or table in ANY_BOARDS_TABLES or not self.board:
            return
        file, is_path = self.board.memory_file, table not in BUILT_IN_TABLES
        if file is None and is_path:  # logs have "identity" for boards without a table
            message = f"the memory of a {profile.name} begins with no table"
            self._add(message, f"write {' or '.join(ANY_BOARDS_TABLES)}", "flash", "table")
        elif file and not is_path and table not in file.named:
            known = (*ANY_BOARDS_TABLES, *file.named)
            self._add(f"a {profile.name} has no such table", suggestion(table, known), "flash", "table")
