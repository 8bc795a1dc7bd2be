"""A session is opened at a door, or refused in one sentence that says why."""

import json
import time
from collections.abc import Mapping
from typing import Any

import zenoh

from hil.client.messages import ClientError

AWAY_S = 1.5
"""Maximum time to look for a bench or a router on another computer. On this one a bench may be starting: it
is looked for until the time of the client is over."""
ANSWER_MS = 1500, 10_000
"""Bounds of the time for the other end to say who it is; zenoh's own is the second."""
_LOOK_AGAIN_S = 0.05
_HERE = ("/127.", "/localhost:", "/[::1]")


def opened(entries: Mapping[str, Any], timeout_s: float) -> zenoh.Session:
    """Open a session, tried until the time is over where nobody listens yet. A door without users, as of a
    router, keeps out who has a password; there it is for signatures alone.

    Raises:
        ClientError: nobody lets it in; the text says what is wrong, where, and what to do.
    """
    from hil.net.door_check import Why
    from hil.net.endpoint import BadAddress, check_joined

    begin_s = time.monotonic()
    endpoints = [str(each) for each in entries.get("connect", {}).get("endpoints", ())]
    try:
        for each in endpoints:
            check_joined(each)
    except BadAddress as error:
        raise ClientError(f"{error}; {error.remedy}") from None
    is_here = any(word in each for word in _HERE for each in endpoints)
    until_s = begin_s + (timeout_s if is_here else min(timeout_s, AWAY_S))
    refusals = 0
    while (session := _tried(entries, timeout_s)) is None:
        reason = reason_of(entries, endpoints)
        refusals += reason.why is not Why.AWAY
        # A door that is flooded refuses too, once.
        if refusals > 1 or time.monotonic() > until_s:
            raise ClientError(reason.text)
        time.sleep(_LOOK_AGAIN_S)
    return session


def _tried(entries: Mapping[str, Any], timeout_s: float) -> zenoh.Session | None:
    transport = {name: value for name, value in entries.get("transport", {}).items() if name != "auth"}
    least_ms, most_ms = ANSWER_MS
    answer_ms = min(max(round(timeout_s * 1000), least_ms), most_ms)
    has_password = "auth" in entries.get("transport", {})
    for tried in (entries, {**entries, "transport": transport})[: 1 + has_password]:
        config = zenoh.Config.from_json5(json.dumps(tried))
        config.insert_json5("connect/timeout_ms", "0")  # once
        config.insert_json5("transport/unicast/open_timeout", str(answer_ms))
        try:
            return zenoh.open(config)
        except zenoh.ZError:
            continue
    return None


def reason_of(entries: Mapping[str, Any], endpoints: list[str]) -> Any:
    """Reason, a ``hil.net.door_check.NotLetIn``, why a session with this configuration is refused."""
    from hil.net.door_check import first_reason

    transport = entries.get("transport", {})
    tls = transport.get("link", {}).get("tls", {})
    user = transport.get("auth", {}).get("usrpwd", {}).get("user")
    has_certificate = any(name.startswith("connect_certificate") for name in tls)
    metadata = entries.get("metadata") or {}
    if user is None and has_certificate:
        return first_reason(endpoints, tls, str(metadata.get("name", "you")), is_key_known=True)
    return first_reason(endpoints, tls, user)
