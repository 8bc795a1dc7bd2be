"""Placeholders of values in help texts, in one style: capitals that say what it is, as in --bench BENCH."""

from typing import Any

_PLACEHOLDERS = {
    "runtime_dir": "FOLDER",
    "state_dir": "FOLDER",
    "sketchbook": "FOLDER",
    "folders": "FOLDER",
    "diff": "OLD",
    "interval_ms": "MS",
    "rate_Hz": "HZ",
    "rotate_mb": "MB",
    "output": "FILE",
    "write": "FILE",
    "log": "FILE",
    "port_group": "GROUP",
    "eds": "NODE=FILE",
    "files": "COUNT",
    "devices": "COUNT",
    "tap": "BUS.TAP",
}


def placeholder(name: str) -> str:
    """Placeholder for the value of an option or an argument, by the parameter's name."""
    return _PLACEHOLDERS.get(name, name.upper().replace("_", "-"))


def with_placeholders(command: Any) -> Any:
    """Let a command, and all below it, show placeholders of this style in its help."""
    for parameter in command.params:
        is_option = parameter.param_type_name == "option"
        if is_option and not parameter.is_flag and parameter.metavar is None:
            parameter.metavar = placeholder(parameter.name)
    for below in getattr(command, "commands", {}).values():
        with_placeholders(below)
    return command
