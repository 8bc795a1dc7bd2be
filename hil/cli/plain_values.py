"""Values of the command line that need no validation, so that a command starts without pydantic.

New versions of typer have pydantic check each value, also of options that were not given, and importing it
takes as long as the rest of a small command. Other versions leave what is set here alone.
"""

from pathlib import Path
from typing import Any

_PLAIN = {str: str, Path: Path}


class PlainValue:
    """Reader of an option's or argument's value, in the place of typer's own, which reads all other kinds."""

    def __init__(self, plain: type) -> None:
        self._plain = plain

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """Value as the command takes it. Raises what typer's own reader raises."""
        is_repeated = param.multiple or param.nargs == -1
        if value is None:
            return () if is_repeated else None
        if not is_repeated:
            if isinstance(value, self._plain):
                return value
            if self._plain in _PLAIN:
                return _PLAIN[self._plain](value)
        param._runtime_param = None
        return param.get_runtime_param().coerce(value, param, ctx)


def with_plain_values(parameters: list[Any]) -> list[Any]:
    """Let parameters be read that way, where typer has them read by pydantic."""
    for parameter in parameters:
        if getattr(parameter, "_runtime_param", parameters) is None and hasattr(parameter, "type_descriptor"):
            annotation = parameter.type_descriptor.annotation
            if isinstance(annotation, type):
                parameter._runtime_param = PlainValue(annotation)
    return parameters
