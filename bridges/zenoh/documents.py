"""JSON documents that go out and come in."""

import json
from collections.abc import Mapping
from typing import Any

from bridges.zenoh.keys import JSON_VERSION
from hil.vocab.desk_protocol import BenchClock, Source
from hil.vocab.verbs import Role, VerbRefused
from hil.wire.json_text import JsonError, read_json

OURS = Source("zenoh", Role.ADMIN, door="zenoh")
"""Source of requests without a user: the bridge's own, and commands where the bench has no users."""
STRANGER = Source("zenoh", Role.VIEWER, door="zenoh")
"""Source of commands whose signature does not do."""
RUN_BYTES = 1 << 20
PAYLOAD_BYTES = 64 * 1024
"""Maximum length of a command's payload."""


def read_payload(payload: bytes | None, wanted: set[type] | None = None, longest: int = PAYLOAD_BYTES) -> Any:
    """Read a command's payload: an object, or a value of the ``wanted`` types; nothing stands for {}.

    Raises:
        VerbRefused: the payload is neither.
    """
    if not payload and wanted is None:
        return {}
    if payload is not None and len(payload) > longest:
        raise VerbRefused("bad_request", f"{len(payload)} bytes; a payload has at most {longest}")
    try:
        value = read_json(payload or b"")
    except JsonError as error:
        raise VerbRefused("bad_request", f"the payload is no JSON: {error}") from None
    if type(value) not in (wanted or {dict}):
        what = "a number" if wanted else 'an object, as in {"position_deg": 90}'
        raise VerbRefused("bad_request", f"the payload has to be {what}")
    return value


def read_text(payload: bytes | None) -> str:
    """Read a run's payload, which its own reader checks. Raises VerbRefused: it is too long, or no text."""
    if len(payload or b"") > RUN_BYTES:
        raise VerbRefused("bad_request", f"{len(payload or b'')} bytes; a run has at most {RUN_BYTES}")
    try:
        return (payload or b"").decode()
    except UnicodeDecodeError as error:
        raise VerbRefused("bad_request", f"the payload is no UTF-8: {error}") from None


def dumped(content: Mapping[str, Any], clock: BenchClock) -> bytes:
    """Encode what is published or answered, with the times."""
    sim_ns, wall_ns = clock.times_ns()
    return json.dumps({"v": JSON_VERSION, "sim_ns": sim_ns, "wall_ns": wall_ns} | dict(content)).encode()
