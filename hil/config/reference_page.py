"""The reference page of all configuration keys, written from the schema."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hil.config.board_numbers import ANY_SUPPLY
from hil.config.board_parameters import BuildParameter
from hil.config.catalogue import AxisInfo, Catalogue, ProfileInfo
from hil.config.motor_bounds import BOUNDS
from hil.config.motors import MEANINGS, MOTORS
from hil.config.schema import schema
from hil.config.shaft_load import LOAD_KINDS


def reference(catalogue: Catalogue) -> str:
    """Write every key with its type, default and meaning, as Markdown."""
    whole: dict[str, Any] = schema(catalogue)
    definitions = whole["$defs"]
    device = definitions["DeviceConfig"]
    sections = [
        "# Configuration reference",
        "A bench is one YAML file. This page is generated from the models that check it; a key that is"
        ' not here is an error. Quote text that looks like a number (`"0.1"`, `"0660"`).',
        "## Bench",
        keys_table(whole),
        "## Device: `devices.<name>`",
        keys_table(device),
        "## Flash: `devices.<name>.flash`",
        keys_table(definitions["FlashConfig"]),
        "## Load: `devices.<name>.load`",
        "`kind`, any kind's `inertia_kg_m2`, and the numbers of the kind.",
        *_loads(definitions),
        "## Axes of a board with several: `devices.<name>.axes.<axis>`",
        keys_table(definitions["AxisConfig"]),
        "## Switches: `switches.<name>`",
        keys_table(next(iter(whole["properties"]["switches"]["patternProperties"].values()))),
        "## Segments: `segments.<name>`",
        keys_table(definitions["SegmentConfig"]),
        "## Taps: `segments.<name>.taps.<name>`",
        keys_table(definitions["TapConfig"]),
        *(
            part
            for bus in catalogue.buses
            for text, name in bus.sections
            for part in (text, keys_table(definitions[name]))
        ),
        "## Recordings: `recordings`",
        keys_table(definitions["RecordingsConfig"]),
        "## Commands: `commands`",
        keys_table(definitions["CommandsConfig"]),
        "## Ports: `devices.<name>.port`",
        "Either the kind's name alone, or a mapping of `kind` and the options below; so are `network` and"
        " each of `ports`.",
    ]
    for port in device["properties"]["port"]["anyOf"][1:]:
        kind = port["properties"].pop("kind")["const"]
        port["required"].remove("kind")
        sections += [f"### `{kind}`", keys_table(port) if port["properties"] else "No options."]
    sections += ["## Set-points: `devices.<name>.setpoints`", keys_table(definitions["SetpointsConfig"])]
    for kind, choice in whole["properties"]["bridges"]["properties"].items():
        sections += [f"## Bridge: `bridges.{kind}`", keys_table(choice["anyOf"][1])]
    sections.append("## Profiles: `devices.<name>.profile`")
    for name in sorted(catalogue.profiles):
        sections += _profile(catalogue.profiles[name])
    sections += [
        *_tables(),
        "## Bounds of motors and loads",
        "What a motor holds is its torque constant times the largest current of a coil. The reasons are in"
        " [decision 0034](decisions/0034-bounds-of-motors.md).",
        _table(
            ("Parameters", "Bound", "Reason"),
            ((", ".join(f"`{name}`" for name in names), *texts) for names, texts in BOUNDS.items()),
        ),
        "## Motors: `motor` of a device or a `profile.yaml`",
        "A profile that names one has its numbers, and writes in `axis` only what differs or comes besides;"
        " so has a device. `hil profile motors` lists them.",
        *_motors(),
    ]
    return "\n\n".join(sections) + "\n"


def _tables() -> Iterable[str]:
    """Sections on boards by a table, whose model no bench needs."""
    from hil.config.dialogue_model import SECTIONS

    for title, model in SECTIONS:
        yield f"## {title}"
        yield keys_table(model.model_json_schema())


def _motors() -> Iterable[str]:
    for name, motor in MOTORS.items():
        yield f"### `{name}`: {motor.title}"
        yield _table(
            ("`axis`", "Value", "Unit", "Source"),
            (
                (f"`{key}`", _two(each.value, each.full), MEANINGS[key]["unit"], each.source)
                for key, each in motor.figures.items()
            ),
        )


def _loads(definitions: dict[str, Any]) -> Iterable[str]:
    for kind, model in LOAD_KINDS.items():
        described = definitions[model.__name__]
        described["properties"].pop("kind")
        yield f"### `{kind}`: {described['description']}"
        yield keys_table(described)


def keys_table(model: dict[str, Any]) -> str:
    """Write the keys of a model with their types, defaults and meanings, as Markdown."""
    required = model.get("required", [])
    return _table(
        ("Key", "Type", "Default", "Meaning"),
        (
            (
                f"`{name}`",
                _type(value),
                "required" if name in required else _default(value),
                value.get("description", ""),
            )
            for name, value in model["properties"].items()
            if not value.get("deprecated")
        ),
    )


def _default(value: dict[str, Any]) -> str:
    return f"`{json.dumps(value['default'])}`" if "default" in value else ""


def _type(value: dict[str, Any]) -> str:
    if "oneOf" in value:
        return "mapping"
    if "anyOf" in value:
        return " or ".join(dict.fromkeys(_type(choice) for choice in value["anyOf"]))
    if "enum" in value or "const" in value:
        return ", ".join(f"`{choice}`" for choice in value.get("enum", [value.get("const")]))
    if "$ref" in value:
        return "mapping"
    plain = {"integer": "whole number", "string": "text", "object": "mapping", "array": "list"}
    name = plain.get(value.get("type", ""), value.get("type", "any"))
    return " ".join(["path" if value.get("format") == "path" else name, *_bounds(value)])


def _bounds(value: dict[str, Any]) -> Iterable[str]:
    words = {"exclusiveMinimum": ">", "minimum": "≥", "maximum": "≤", "exclusiveMaximum": "<"}
    return [f"{word} {value[key]}" for key, word in words.items() if key in value]


def _profile(profile: ProfileInfo) -> list[str]:
    hardware = _table(
        ("`hardware`", "Supply (V)", "5 V inputs"),
        (
            (
                f'`"{name}"`' + (" (default)" if name == profile.default_hardware else ""),
                f"{version.supply_min_V:g} to {version.supply_max_V:g}",
                ", ".join(version.inputs_5V),
            )
            for name, version in profile.hardware.items()
        ),
    )
    axes = (_axis(name if len(profile.axes) > 1 else "", info) for name, info in profile.axes.items())
    supplies = [hardware] if [*profile.hardware.values()] != [ANY_SUPPLY] else []
    build = [_build(profile.parameters)] if profile.parameters else []
    tables = (table for each in axes for table in each)
    return [f"### `{profile.name}`: {profile.title}", *supplies, *build, *tables]


def _build(parameters: Mapping[str, BuildParameter]) -> str:
    return _table(
        ("`parameters`", "Default", "Values", "Unit", "Meaning", "Source"),
        (
            (f"`{name}`", item.shown_default(), item.values(), item.unit, item.about, item.source)
            for name, item in parameters.items()
        ),
    )


def _axis(name: str, info: AxisInfo) -> list[str]:
    """Tables of an axis. ``name``: of one of several."""
    keys = f"axes.{name}." if name else ""
    axis = _table(
        (f"`{keys}axis`", "Default", "Unit", "Meaning", "Source"),
        (
            (f"`{each}`", _two(item.value, item.full), item.unit, item.about, item.source)
            for each, item in info.axis.items()
        ),
    )
    registers = _table(
        (f"`{keys}registers`", "Default"),
        ((f"`{each}`", f"`0x{value:04X}`") for each, value in info.registers.items()),
    )
    return [table for table, rows in ((axis, info.axis), (registers, info.registers)) if rows]


def _two(value: float, full: float | None) -> str:
    return f"{value:g}" if full is None else f"{value:g}; `plant: full`: {full:g}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)
