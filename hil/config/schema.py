"""Configuration as a JSON Schema (draft 2020-12), from which an editor completes and checks."""

import copy
from typing import Any

from pydantic import BaseModel

from hil.config.bench_models import bench_model
from hil.config.board_numbers import AxisParameter
from hil.config.catalogue import AxisInfo, Catalogue, ProfileInfo, usable
from hil.config.check_ports import DEFAULT_PORT
from hil.vocab.address import NAME_PATTERN


def schema(catalogue: Catalogue) -> dict[str, object]:
    """Make the schema of what ``parse`` takes with this catalogue. Checks that need arithmetic across keys
    (supply ranges, two ports in one place) are left to ``parse``."""
    result: dict[str, Any] = bench_model(catalogue.buses).model_json_schema()
    definitions: dict[str, Any] = result["$defs"]
    for replaced in ("PortConfig", "BaseModel"):
        definitions.pop(replaced, None)
    devices = result["properties"]["devices"]
    devices["additionalProperties"] = False
    device = definitions["DeviceConfig"]
    properties = device["properties"]
    properties["profile"]["enum"] = sorted(catalogue.profiles)
    ports, bridges = usable(catalogue.ports), usable(catalogue.bridges)
    kinds = [
        {"enum": sorted(ports)},
        *(_port(kind, model, definitions) for kind, model in sorted(ports.items())),
    ]
    taps = [each for name, each in definitions.items() if name.endswith("TapConfig")]
    for port in (properties["port"], *(tap["properties"]["port"] for tap in taps)):
        port |= {"default": DEFAULT_PORT, "anyOf": copy.deepcopy(kinds)}
        port.pop("$ref", None)
    properties["network"] = {
        "description": properties["network"]["description"],
        "default": None,
        "anyOf": [{"type": "null"}, *kinds],
    }
    if "map" in properties:
        properties["map"]["anyOf"].insert(
            0, {"type": "string", "minLength": 1, "description": "A file's path."}
        )
    properties["ports"]["additionalProperties"] = False
    properties["ports"]["patternProperties"] = {NAME_PATTERN: {"anyOf": copy.deepcopy(kinds)}}
    for tap in taps:
        tap.pop("required", None)
    result["properties"]["bridges"] |= {
        "additionalProperties": False,
        "properties": {
            kind: {"anyOf": [{"type": "null"}, _options(f"bridge_{kind}_", model, definitions)]}
            for kind, model in sorted(bridges.items())
        },
    }
    # The catalogue fills these in when they are left out.
    device["required"] = ["profile"]
    device["allOf"] = [_profile(profile) for _, profile in sorted(catalogue.profiles.items())]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **result}


def _options(prefix: str, model: type[BaseModel], definitions: dict[str, Any]) -> dict[str, Any]:
    options: dict[str, Any] = model.model_json_schema(ref_template=f"#/$defs/{prefix}{{model}}")
    definitions.update({prefix + name: value for name, value in options.pop("$defs", {}).items()})
    return options


def _port(kind: str, model: type[BaseModel], definitions: dict[str, Any]) -> dict[str, Any]:
    options = _options(f"port_{kind}_", model, definitions)
    options["properties"] = {
        "kind": {"const": kind, "description": f"The kind of port: {kind}."},
        **options.get("properties", {}),
    }
    options["required"] = ["kind", *options.get("required", [])]
    options["additionalProperties"] = False
    return options


def _profile(profile: ProfileInfo) -> dict[str, Any]:
    versions = "; ".join(
        f"{name}: {v.supply_min_V:g} to {v.supply_max_V:g} V, 5 V inputs {', '.join(v.inputs_5V)}"
        for name, v in profile.hardware.items()
    )
    return {
        "if": {"properties": {"profile": {"const": profile.name}}, "required": ["profile"]},
        "then": {
            "properties": {
                "hardware": {
                    "enum": list(profile.hardware),
                    "default": profile.default_hardware,
                    "description": versions,
                },
                **_axis(next(iter(profile.axes.values()), None)),
                **_no_uarts(profile),
                "parameters": {
                    "properties": {name: each.json_values() for name, each in profile.parameters.items()},
                    "additionalProperties": False,
                },
                "axes": {
                    "properties": {name: {"properties": _axis(info)} for name, info in profile.axes.items()},
                    "additionalProperties": False,
                },
            }
        },
    }


def _no_uarts(profile: ProfileInfo) -> dict[str, Any]:
    """Schema of a board without serial interfaces: their keys may only be null."""
    return {} if profile.uarts else {key: {"type": "null"} for key in ("port", "network", "baud")}


def _axis(info: AxisInfo | None) -> dict[str, Any]:
    """Properties that the keys of an axis have by its profile; None: there is no axis."""
    parameters = {name: _parameter(item) for name, item in info.axis.items()} if info else {}
    registers = {
        name: {"default": value, "description": f"Register {name} at power-up."}
        for name, value in (info.registers if info else {}).items()
    }
    return {
        "axis": {"properties": parameters, "additionalProperties": False},
        "registers": {"properties": registers, "additionalProperties": False},
    }


def _parameter(parameter: AxisParameter) -> dict[str, Any]:
    result: dict[str, Any] = {
        "type": "integer" if parameter.whole else "number",
        "default": parameter.value,
        "description": f"{parameter.about} Unit: {parameter.unit}. Source: {parameter.source}.",
    }
    bounds = {
        "minimum": parameter.minimum,
        "maximum": parameter.maximum,
        "exclusiveMinimum": parameter.above,
    }
    return result | {name: bound for name, bound in bounds.items() if bound is not None}
