"""Checks of paths that a configuration names; nothing is opened."""

from typing import Any

from pydantic_core import PydanticCustomError


def usable_path(value: Any) -> Any:
    """Check that a value is no path that nothing expands or opens; other types are left to the model."""
    if isinstance(value, str) and (not value or "\0" in value):
        raise PydanticCustomError("path", "this is not a path", {"remedy": "write the path, or null"})
    if isinstance(value, str) and value.startswith("~"):
        raise PydanticCustomError("path", "no shell expands ~ here", {"remedy": "write the whole path"})
    return value


def is_path(value: object) -> bool:
    """True if the value of a key for a path can be a path."""
    return isinstance(value, str) and bool(value) and "\0" not in value and not value.startswith("~")
