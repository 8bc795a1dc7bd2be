"""Messages between bench and client, as values."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hil.wire.json_text import JsonError, read_json

JSON_VERSION = 1
_HEAD = ("v", "sim_ns", "wall_ns", "effective_at_ns", "key")


class ClientError(Exception):
    """Error of a bench that does not answer, or not as it should: ``str(error)`` says what."""


class CommandError(ClientError):
    """Refusal of a command. ``code`` is one of ``hil.vocab.verbs.CODES``."""

    def __init__(self, code: str, why: str) -> None:
        super().__init__(why)
        self.code = code


@dataclass(frozen=True)
class Ack:
    """Acknowledgement of a command that has taken effect at ``effective_at_ns`` (simulated; None for what has
    no time). ``sim_ns`` and ``wall_ns``: when the answer was written. ``answer``: the verb's own."""

    effective_at_ns: int | None
    sim_ns: int
    wall_ns: int
    answer: Mapping[str, Any]


@dataclass(frozen=True)
class State:
    """State of an axis at simulated time ``at_ns``: its fields as attributes (``state.position_deg``) and in
    ``fields``. The units are in the names; a value that is no number is None."""

    at_ns: int
    wall_ns: int
    fields: Mapping[str, Any]

    def __getattr__(self, name: str) -> Any:
        try:
            return self.fields[name]
        except KeyError:
            raise AttributeError(f"this state has no {name!r}; it has {', '.join(self.fields)}") from None


def read(text: bytes) -> dict[str, Any]:
    """Read a message of the version that is known here.

    Raises:
        ClientError: the text is no such message.
    """
    try:
        message = read_json(text)
        version = message["v"]
    except (JsonError, KeyError, TypeError, IndexError):
        raise ClientError(f"this is no message of a bench: {text[:80]!r}") from None
    if version != JSON_VERSION:
        raise ClientError(f"the bench speaks version {version}; this client knows {JSON_VERSION}")
    return dict(message)


def ack_of(text: bytes) -> Ack:
    message = read(text)
    answer = {name: value for name, value in message.items() if name not in _HEAD}
    return Ack(message.get("effective_at_ns"), message["sim_ns"], message["wall_ns"], answer)


def error_of(text: bytes) -> CommandError:
    message = read(text)
    return CommandError(str(message.get("code")), str(message.get("error")))


def state_of(text: bytes) -> State:
    message = read(text)
    fields = {name: value for name, value in message.items() if name not in _HEAD}
    return State(fields.pop("at_ns"), message["wall_ns"], fields)
