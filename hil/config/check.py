"""Checks of a bench's text or mapping, which find every problem at once."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hil.config.bench_models import bench_model
from hil.config.bridge_findings import BRIDGES, bridge_findings, file_findings, read_bridges
from hil.config.catalogue import Catalogue, ProfileInfo
from hil.config.check_device import DeviceCheck
from hil.config.check_ports import DEFAULT_PORT, PortsCheck
from hil.config.document import Document, Finding, document_from_mapping
from hil.config.document_kinds import BENCH, check_kind
from hil.config.explain import findings_of
from hil.config.fault_findings import fault_findings
from hil.config.framing_findings import framing_findings
from hil.config.joint_findings import joint_findings
from hil.config.magnet_findings import magnet_findings
from hil.config.model import BenchConfig
from hil.config.motor_findings import motor_findings
from hil.config.port_model import SERIAL, is_path
from hil.config.processor_findings import processor_findings
from hil.config.real_places import same_at
from hil.config.switch_findings import switch_findings
from hil.config.written import written
from hil.config.yaml_text import document_from_yaml
from hil.vocab.address import DeviceParts
from hil.vocab.problem import ConfigError, Problem

PROFILE_PATH = "profile_path"
"""Key of the folders in which more boards are."""


def parse(text: str, file: str, catalogue: Catalogue, *, opens_bridges: bool = False) -> BenchConfig:
    """Read a bench's YAML. ``file`` is the name that problems carry; nothing is opened. With
    ``opens_bridges`` its bridges are to be opened: what they could not be opened with is a problem, and the
    files that their options name are read. A reload leaves them open, whatever their axes become.

    Raises:
        ConfigError: with all problems, in file order.
    """
    document = document_from_yaml(text, file)
    if document.value is None and not document.findings:
        remedy = 'begin with "bench: NAME" and "devices:"'
        raise document.error([Finding((), "the file is empty", remedy)])
    check_kind(document, BENCH)
    return _check(document, catalogue, opens_bridges=opens_bridges)


def from_dict(data: Mapping[str, object], catalogue: Catalogue) -> BenchConfig:
    """Read the same bench from Python data, with the same checks; problems have line 0.

    Raises:
        ConfigError: with all problems.
    """
    return _check(document_from_mapping(data, "<dict>"), catalogue)


def _check(document: Document, catalogue: Catalogue, *, opens_bridges: bool = False) -> BenchConfig:
    catalogue, wrong_paths = _with_path(document, catalogue)
    ports = PortsCheck(document, catalogue.ports)
    value, found, profiles, elsewhere, of_files = _completed(document, catalogue, ports)
    findings = [*document.findings, *wrong_paths, *found]
    model = bench_model(catalogue.buses)
    config: BenchConfig | None = None
    try:
        config = model.model_validate(value)
    except ValidationError as error:
        findings += findings_of(error, model, (), document)
    if profiles is not None:
        findings += _findings_between(value, profiles, catalogue)
        findings += framing_findings(value, profiles, catalogue)
    if opens_bridges and isinstance(value, dict) and isinstance(bridges := value.get(BRIDGES), dict):
        findings += bridge_findings(bridges, value, profiles) if profiles else []
        findings += file_findings(bridges)
    spoilt = of_files | {finding.path[1] for finding in findings if len(finding.path) > 1}
    wrong_keys = {finding.path[0] for finding in findings if finding.path}
    if good := (None if elsewhere else config) or _good_part(value, model, wrong_keys, spoilt):
        findings += motor_findings(good, catalogue, spoilt)
    if config is None or findings or elsewhere:
        of_boards = _of_boards(value, catalogue)
        raise ConfigError([*document.error(findings).problems, *elsewhere, *of_boards])
    return config.with_written(written(document, ports.old_keys))


def _good_part(
    value: Any, model: type[BenchConfig], wrong_keys: Collection[object], spoilt: Collection[object]
) -> BenchConfig | None:
    """Bench of those keys and devices that have no findings, so that its motors are checked in the same turn;
    None: what is left is no bench."""
    if not isinstance(value, dict) or not isinstance(devices := value.get("devices"), dict):
        return None
    kept = {key: each for key, each in value.items() if key not in wrong_keys}
    good = {name: raw for name, raw in devices.items() if name not in spoilt}
    try:
        return model.model_validate({"bench": "bench", **kept, "devices": good})
    except ValidationError:
        return None


def _with_path(document: Document, catalogue: Catalogue) -> tuple[Catalogue, list[Finding]]:
    """Find the catalogue with the boards in a document's own folders, which are looked up from its file."""
    given: Any = document.value
    folders = given.get(PROFILE_PATH) if isinstance(given, dict) else None
    if not isinstance(folders, list) or not catalogue.at:
        return catalogue, []
    base = Path(document.file).parent
    known = {index: base / each for index, each in enumerate(folders) if is_path(each)}
    found = catalogue.at(tuple(known.values()))
    places = dict(enumerate(known))
    wrong = [Finding((PROFILE_PATH, places[index]), *why) for index, why in found.wrong_paths.items()]
    return found, wrong


def _of_boards(value: Any, catalogue: Catalogue) -> list[Problem]:
    """Problems of the boards that a configuration names, each once."""
    devices = value.get("devices") if isinstance(value, dict) else None
    raws = [raw for raw in devices.values() if isinstance(raw, dict)] if isinstance(devices, dict) else []
    names = dict.fromkeys(raw["profile"] for raw in raws if isinstance(raw.get("profile"), str))
    return [problem for name in names for problem in catalogue.problems(name)]


def _completed(
    document: Document, catalogue: Catalogue, ports: PortsCheck
) -> tuple[Any, list[Finding], dict[str, ProfileInfo] | None, list[Problem], set[str]]:
    """Complete a document with the catalogue's defaults: its value, the findings, the profiles of all
    devices, problems of files that it names, and the devices that name these, or have a profile that is not
    known. The profiles are None if there are no devices, or not all profiles are known."""
    given: Any = document.value
    if not isinstance(given, dict) or not isinstance(given.get("devices"), dict):
        return given, [], None, [], set()
    devices = {
        name: DeviceCheck(name, raw, document, catalogue, ports)
        for name, raw in given["devices"].items()
        if isinstance(raw, dict)
    }
    findings = [finding for device in devices.values() for finding in device.findings]
    if catalogue.path:
        given = {**given, PROFILE_PATH: list(catalogue.path)}
    value = {**given, "devices": given["devices"] | {name: each.completed for name, each in devices.items()}}
    for key in bench_model(catalogue.buses).bus_keys:
        if isinstance(wires := given.get(key), dict):
            value[key] = {name: _with_taps(key, name, raw, ports) for name, raw in wires.items()}
    problems: list[Problem] = []
    for kind in catalogue.wire_kinds:
        if kind.read and isinstance(wires := value.get(kind.key), dict):
            value[kind.key], wrong, of_files = kind.read(wires, document, catalogue.read_bytes)
            findings += wrong
            problems += of_files
    for name, raw in given["devices"].items():
        if isinstance(raw, dict) and isinstance(at := raw.get("at"), str):
            ports.real(name, ("devices", name, "at"), at)
    if isinstance(bridges := given.get(BRIDGES), dict):
        value[BRIDGES], wrong = read_bridges(bridges, catalogue, document, ports)
        findings += wrong
    findings = [*ports.findings, *findings, *ports.clashes(given.get("runtime_dir"), given.get("bench"))]
    profiles = {name: device.profile for name, device in devices.items() if device.profile}
    are_all = profiles and len(profiles) == len(given["devices"])
    of_devices = (problem for device in devices.values() for problem in device.problems)
    elsewhere = list(dict.fromkeys([*of_devices, *problems, *catalogue.bus_problems]))
    of_files = {name for name, device in devices.items() if device.problems or not device.profile}
    return value, findings, profiles if are_all else None, elsewhere, of_files


def _with_taps(key: str, name: str, line: Any, ports: PortsCheck) -> Any:
    """Complete a segment or another wire, by the key under which it stands, with its taps' ports."""
    taps = line.get("taps") if isinstance(line, dict) else None
    if not isinstance(taps, dict):
        return line
    done = dict(taps)
    for tap, keys in taps.items():
        if isinstance(keys, dict):
            path = (key, name, "taps", tap, "port")
            port = ports.read(f"{name}.{tap}", path, keys.get("port", DEFAULT_PORT))
            is_real = key == "segments" and port.kind == SERIAL
            if is_real and isinstance(echo := keys.get("echo"), bool):
                port = port.model_copy(update={"options": port.options.model_copy(update={"echo": echo})})
            own = {"real": is_real} if key == "segments" else {}
            done[tap] = {**own, **keys, "port": port}
    return {**line, "taps": done}


def _findings_between(
    value: dict[str, Any], profiles: Mapping[str, ProfileInfo], catalogue: Catalogue
) -> Iterator[Finding]:
    devices = value["devices"]
    real = {name for name, raw in devices.items() if raw.get("at") is not None}
    full = {
        axes.label(name, axis)
        for name, raw in devices.items()
        for axes in (DeviceParts(profiles[name].axes),)
        for axis in axes
        if name not in real and _plant(raw, axis) == "full"
    }
    yield from joint_findings(value, profiles, real)
    yield from processor_findings(value, profiles, real)
    yield from magnet_findings(value, profiles, real)
    yield from switch_findings(value, profiles, real)
    if isinstance(segments := value.get("segments"), dict):
        for nodes in catalogue.node_kinds:
            yield from nodes.findings(segments, profiles, real)
    for kind in catalogue.wire_kinds:
        yield from kind.findings(value, profiles, real)
    yield from fault_findings(value, profiles, real, full, catalogue)
    yield from same_at(devices, catalogue.drive_kinds)


def _plant(raw: Mapping[str, Any], axis: str) -> object:
    """Plant of a device's axis, by its own key or the device's."""
    axes = raw.get("axes")
    own = axes.get(axis) if isinstance(axes, dict) else None
    return (own.get("plant") if isinstance(own, dict) else None) or raw.get("plant")
