"""Checks of bridges: their options by the models of their kinds, and beside the rest of the configuration."""

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from hil.config.catalogue import Catalogue, ProfileInfo
from hil.config.check_ports import PortsCheck
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import findings_of, shown, suggestion
from hil.config.written import old_key_problems
from hil.vocab.address import DeviceParts
from hil.vocab.problem import Unusable

if TYPE_CHECKING:  # many benches have no bridge: the protocol is imported for one
    from hil.vocab.bridge_protocol import OptionProblem

BRIDGES = "bridges"
Options = Mapping[str, BaseModel]


def read_bridges(
    raw: Mapping[str, object], catalogue: Catalogue, document: Document, ports: PortsCheck
) -> tuple[dict[str, BaseModel], list[Finding]]:
    """Read the options of each bridge, and note its ports; answers the options and the findings. ``~`` stands
    for the defaults."""
    from hil.vocab.bridge_protocol import BridgeOptions

    options: dict[str, BaseModel] = {}
    findings: list[Finding] = []
    for name, given in raw.items():
        path, kinds = (BRIDGES, name), catalogue.bridges
        if name not in kinds:
            findings.append(
                Finding(path, f"there is no bridge {shown(name)}", suggestion(name, kinds), at_key=True)
            )
            continue
        if given is not None and not isinstance(given, Mapping):
            findings.append(
                Finding(path, f"options are wanted here, not {shown(given)}", "write {} for none")
            )
            continue
        try:
            # As JSON, so that strict still reads a path or an enumeration from text.
            read = options[name] = kinds[name].model_validate_json(json.dumps(dict(given or {})), strict=True)
        except Unusable as error:
            findings.append(
                Finding(path, f"bridge {name} cannot be used: {error}", error.remedy, at_key=True)
            )
        except ValidationError as error:
            findings += findings_of(error, kinds[name], path, document)
            if rest := _rest(kinds[name], given, error):
                options[name] = rest
        else:
            ports.old_keys += old_key_problems(document, path, dict(given or {}), read)
            ports.door(name, read)
            for port in read.wanted_ports() if isinstance(read, BridgeOptions) else ():
                ports.want(f"the bridge {name}", (*path, *port.place), port)
    return options, findings


def _rest(model: type[BaseModel], given: object, error: ValidationError) -> BaseModel | None:
    """Options without the rows that are wrong, as of units, so that what else is wrong is found too; None:
    something else is wrong."""
    left: dict[str, Any] = json.loads(json.dumps(given or {}))
    places = [tuple(map(str, each["loc"])) for each in error.errors(include_url=False)]
    for place in places:
        rows = left.get(place[0]) if len(place) > 1 else None
        if not isinstance(rows, dict):
            return None
        rows.pop(place[1], None)
    try:
        rest = model.model_validate_json(json.dumps(left), strict=True)
    except (ValidationError, Unusable):
        return None
    return rest if all(isinstance(getattr(rest, key, None), Mapping) for key, *_ in places) else None


def bridge_findings(
    options: Options, value: Mapping[str, Any], profiles: Mapping[str, ProfileInfo]
) -> list[Finding]:
    """Findings of bridges on this bench. ``value``: the configuration; ``profiles``: of all of its devices.
    A bridge that names wires has those of its own bus."""
    from hil.vocab.bridge_protocol import BridgeOptions, BusOptions

    axes = [
        axis
        for name, raw in value["devices"].items()
        for axis in _axes(name, profiles[name], is_real=raw.get("at") is not None)
    ]
    wires = {name: each if isinstance(each := value.get(name), dict) else {} for name in options}
    on_buses = [
        _finding(name, problem)
        for name, each in options.items()
        if isinstance(each, BusOptions)
        for problem in each.bus_problems(wires[name])
    ]
    return on_buses + [
        _finding(name, problem)
        for name, each in options.items()
        if isinstance(each, BridgeOptions)
        for problem in each.problems(axes)
    ]


def file_findings(options: Options) -> list[Finding]:
    """Findings in files that the options of bridges name."""
    from hil.vocab.bridge_protocol import BridgeOptions

    return [
        _finding(name, problem)
        for name, each in options.items()
        if isinstance(each, BridgeOptions)
        for problem in each.file_problems()
    ]


def _axes(device: str, profile: ProfileInfo, *, is_real: bool) -> Iterable[str]:
    """Addresses of a device and of its further axes. Of a real board only the first one is known."""
    axes = DeviceParts(profile.axes)
    return [device] if is_real else [device, *(axes.label(device, axis) for axis in list(axes)[1:])]


def _finding(bridge: str, problem: "OptionProblem") -> Finding:
    path: KeyPath = (BRIDGES, bridge, *problem.path)
    return Finding(path, problem.message, problem.remedy, problem.at_key)
