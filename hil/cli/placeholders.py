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
    "sources": "SOURCE",
    "values": "VALUE",
    "parameters": "NAME=VALUE",
    "config": "FILE",
    "host": "HOST",
    "user": "NAME:ROLE",
}


def placeholder(name: str) -> str:
    """Placeholder for the value of an option or an argument, by the parameter's name."""
    return _PLACEHOLDERS.get(name, name.upper().replace("_", "-"))


def usage_word(argument: Any) -> str:
    """Argument as a usage line has it: DEVICE, [VERB], [VALUE...]."""
    word = (argument.metavar or placeholder(argument.name)).removesuffix("...")
    word += "..." * (argument.nargs == -1)
    return word if argument.required else f"[{word}]"


def with_placeholders(parameters: list[Any]) -> list[Any]:
    """Let options show placeholders of this style in help texts."""
    for parameter in parameters:
        is_option = parameter.param_type_name == "option"
        if is_option and not parameter.is_flag and parameter.metavar is None:
            parameter.metavar = placeholder(parameter.name)
    return parameters
