"""Model of names, ports and paths in a configuration, checked; nothing is opened."""

from typing import Annotated, Any

from pydantic import BaseModel, Field, SerializeAsAny
from pydantic_core import PydanticCustomError

from hil.config.explain import StrictModel
from hil.vocab.address import NAME_PATTERN


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


SERIAL = "serial"
"""Kind of port at which hil itself uses a real adapter."""

USUAL_BAUD = 38400
"""Speed of a segment without stations, if nobody says another."""

Name = Annotated[str, Field(pattern=NAME_PATTERN)]


class PortConfig(StrictModel):
    """Port at which clients reach a device: its kind and that kind's own options."""

    kind: str
    options: SerializeAsAny[BaseModel]
