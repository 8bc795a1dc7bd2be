"""Option ``listen`` of doors and ports: one form for all, and the keys that it had before."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    WithJsonSchema,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

from hil.net.endpoint import LOOPBACK, BadAddress, authority, listen_address

HOST, PORT = "host", "port"
"""Keys up to 0.2, of the page's door and of the ports tcp and rfc2217."""
ADDRESS_SCHEMA = WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "integer"}]})
"""Types of an address in the JSON Schema: text, or a port alone."""


def usual_at(port: int | None) -> BeforeValidator:
    """Validator of an address; ``port``: the usual one of the door, as ``listen_address`` has it."""

    def complete(given: Any) -> Any:
        return _complete(given, port) if _is_text_or_number(given) else given

    return BeforeValidator(complete)


def _complete(given: str | int, port: int | None, at: tuple[str, ...] = ()) -> str:
    try:
        return listen_address(given, port)
    except BadAddress as error:
        problem = {"why": str(error), "remedy": error.remedy, "at": at}
        raise PydanticCustomError("listen", "{why}", problem) from None


def _is_text_or_number(given: object) -> bool:
    return isinstance(given, str | int) and not isinstance(given, bool)


class OldKeys(BaseModel):
    """Options of what had ``host`` and ``port`` for its address, and has ``listen`` now. ``port_left_out``:
    the port where none was written, as ``listen_address`` has it."""

    model_config = ConfigDict(strict=True, extra="forbid")
    old_keys: ClassVar[tuple[str, ...]] = (HOST, PORT)
    port_left_out: ClassVar[int | None] = 0

    @model_validator(mode="before")
    @classmethod
    def _of_old_keys(cls, given: Any) -> Any:
        if not isinstance(given, Mapping) or not (old := [key for key in cls.old_keys if key in given]):
            return given
        if "listen" in given:
            raise PydanticCustomError(
                "listen",
                "{old} beside listen: the address is there twice",
                {"old": ", ".join(old), "at": (old[0],), "remedy": "leave out the old key"},
            )
        host, port = given.get(HOST, LOOPBACK), given.get(PORT)
        if not isinstance(host, str):
            raise _wrong(HOST, f"text is wanted here, not {host!r}", "write listen: 127.0.0.1:8080")
        if port is not None and (not isinstance(port, int) or isinstance(port, bool)):
            raise _wrong(PORT, f"a whole number is wanted here, not {port!r}", "write listen: 127.0.0.1:8080")
        bare = f"[{host}]" if ":" in host else host
        _complete(bare, cls.port_left_out, (HOST,))
        if port is not None:
            _complete(port, cls.port_left_out, (PORT,))
        listen = authority(host, cls.port_left_out if port is None else port)
        return {**{key: each for key, each in given.items() if key not in old}, "listen": listen}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        made = handler(schema)
        properties = handler.resolve_ref_schema(made)["properties"]
        for key in cls.old_keys:
            about = "Old key, for a release: `listen` has both host and port."
            properties[key] = {"deprecated": True, "description": about}
        return made


def _wrong(key: str, why: str, remedy: str) -> PydanticCustomError:
    return PydanticCustomError("listen", "{why}", {"why": why, "at": (key,), "remedy": remedy})


class ListenOptions(OldKeys):
    """Address to listen at, for a port."""

    listen: Annotated[str, usual_at(0), ADDRESS_SCHEMA] = Field(
        default="127.0.0.1:0",
        description="Address and port to listen at, as in `127.0.0.1:7001`; a port alone is of this computer,"
        " port 0, or none, is any free one, shown in the address. Anybody who can reach it can command the"
        " device.",
    )
