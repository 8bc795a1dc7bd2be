"""Reason why nobody is let in at a door of zenoh, whose own word is the same for all: looked at in the order
in which a session is opened, the connection, the certificates, and what is left."""

import base64
import os
import re
import socket
import ssl
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from enum import Enum
from typing import Any, NamedTuple

CHECK_S = 0.6
"""Maximum time to look at one address."""
ALERT_S = 0.35
"""Time for the other end's word on a certificate, which comes behind the handshake: 0.1 s (measured)."""
_ENDPOINT = re.compile(r"(tcp|tls)/(?:\[([^]]+)\]|([^]:/]+)):(\d+)")
_NOT_OURS = ("UNKNOWN_CA", "DECRYPT_ERROR", "BAD_CERTIFICATE", "CERTIFICATE_UNKNOWN", "ACCESS_DENIED")


class Why(Enum):
    """Kind of reason. All but ``AWAY`` hold until somebody changes something."""

    AWAY = "nobody listens there"
    NO_CERTIFICATE = "it wants a certificate"
    OTHER_SITE = "the certificates are of two sites"
    TIMES = "a certificate is not valid now"
    REFUSED = "user or password"
    OTHER = "something else"


class NotLetIn(NamedTuple):
    """Reason, and the sentence that says what is wrong, where, and what to do."""

    why: Why
    text: str


def why_not(
    endpoint: str, tls: Mapping[str, Any], user: str | None, *, is_key_known: bool = False
) -> NotLetIn:
    """Find out why a session was refused, within about a second. ``endpoint``: as in ``tcp/10.0.0.1:7447``;
    ``tls``: zenoh's keys of ``transport/link/tls``; ``user``: the name at the door, None: without one;
    ``is_key_known``: its certificate stands for it, and there is no password."""
    found = _ENDPOINT.match(endpoint)
    if found is None:
        return NotLetIn(Why.OTHER, f"{endpoint}: no session there; is a bench or a router running at it?")
    scheme, host, port = found[1], found[2] or found[3], int(found[4])
    try:
        with socket.create_connection((host, port), CHECK_S) as line:
            refused = _of_tls(endpoint, line, host, tls) if scheme == "tls" else _of_tcp(endpoint, line)
    except socket.gaierror:
        return NotLetIn(Why.AWAY, f"{endpoint}: no computer is called {host!r}; correct the address")
    except OSError as error:
        why = "does not answer" if isinstance(error, TimeoutError) else (error.strerror or str(error)).lower()
        said = f"{endpoint}: no router and no bench listens there ({why})"
        return NotLetIn(Why.AWAY, f"{said}; start it, or correct the address")
    return refused or NotLetIn(Why.REFUSED, f"{endpoint}: {_of_user(user, is_key_known)}")


def _of_user(user: str | None, is_key_known: bool) -> str:
    if user is None:
        return "it lets in users alone; give user and password, or your folder's zenoh.json"
    if is_key_known:
        return f"it does not let in {user}, whose certificate is right; ask whether the site still has {user}"
    return f"it does not let in {user}: the password is wrong, or it has no such user; ask for your files"


def _of_tcp(endpoint: str, line: socket.socket) -> NotLetIn | None:
    """Look whether TLS is spoken at a plain address."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    line.settimeout(ALERT_S)
    try:
        context.wrap_socket(line).close()
    except (OSError, ValueError):
        return None
    said = f"{endpoint}: it wants certificates (TLS)"
    return NotLetIn(Why.NO_CERTIFICATE, f"{said}; write tls/ for tcp/, with your folder's zenoh.json")


def _of_tls(endpoint: str, line: socket.socket, host: str, tls: Mapping[str, Any]) -> NotLetIn | None:
    """Look at the certificates of both ends."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    try:
        authority = _pem(tls, "root_ca_certificate").decode()
        own = [_pem(tls, name) for name in ("connect_certificate", "connect_private_key")]
        if not authority:
            said = f"{endpoint}: it wants certificates, and none are given"
            return NotLetIn(Why.NO_CERTIFICATE, f"{said}; use your folder's zenoh.json")
        context.load_verify_locations(cadata=authority)
        context.check_hostname = tls.get("verify_name_on_connect", True) is not False
        if all(own):
            with _as_file(own) as path:
                context.load_cert_chain(path)
    except (OSError, ValueError) as error:
        return NotLetIn(Why.OTHER, f"{endpoint}: a certificate cannot be read ({error}); copy the folder")
    try:
        with context.wrap_socket(line, server_hostname=host) as shaken:
            shaken.settimeout(ALERT_S)
            with suppress(TimeoutError):
                shaken.recv(1)
    except ssl.SSLCertVerificationError as error:
        return _of_theirs(endpoint, error)
    except ssl.SSLError as error:
        return _of_alert(endpoint, error.reason or "", has_own=all(own))
    except OSError:
        return None
    return None


def _of_theirs(endpoint: str, error: ssl.SSLCertVerificationError) -> NotLetIn:
    said = error.verify_message
    if "expired" in said or "not yet valid" in said:
        when = "has expired" if "expired" in said else "is not yet valid"
        todo = "make it new, or set this computer's clock"
        return NotLetIn(Why.TIMES, f"{endpoint}: its certificate {when}; {todo}")
    if "purpose" in said:
        todo = "start it with its own, as router.pem"
        return NotLetIn(Why.OTHER, f"{endpoint}: its certificate is not one of a router or a bench; {todo}")
    if "match" in said:
        todo = "connect to a name that it has, or make it with this one (--host)"
        return NotLetIn(Why.OTHER_SITE, f"{endpoint}: its certificate is for another address; {todo}")
    todo = "use the folder that this site gave you"
    return NotLetIn(Why.OTHER_SITE, f"{endpoint}: its certificate is of another site than yours; {todo}")


def _of_alert(endpoint: str, reason: str, *, has_own: bool) -> NotLetIn | None:
    if "CERTIFICATE_REQUIRED" in reason or (not has_own and "HANDSHAKE_FAILURE" in reason):
        todo = "use your folder's zenoh.json"
        return NotLetIn(Why.NO_CERTIFICATE, f"{endpoint}: it wants a certificate, and none is given; {todo}")
    if "EXPIRED" in reason:
        todo = "have it made new, or set this computer's clock"
        return NotLetIn(Why.TIMES, f"{endpoint}: your certificate is not valid now; {todo}")
    if "REVOKED" in reason:
        return NotLetIn(Why.REFUSED, f"{endpoint}: the site has revoked your certificate; ask for another")
    if any(word in reason for word in _NOT_OURS):
        todo = "use the folder that this site gave you"
        return NotLetIn(Why.OTHER_SITE, f"{endpoint}: your certificate is of another site; {todo}")
    said = f"{endpoint}: no TLS is spoken there ({reason.lower().replace('_', ' ')})"
    return NotLetIn(Why.OTHER, f"{said}; write tcp/ for tls/, or correct the port")


def _pem(tls: Mapping[str, Any], name: str) -> bytes:
    """Certificate or key that stands in zenoh's configuration, or in a file that it names; empty: none."""
    if text := tls.get(f"{name}_base64"):
        return base64.b64decode(text)
    if path := tls.get(name):
        with open(path, "rb") as file:
            return file.read()
    return b""


@contextmanager
def _as_file(parts: Sequence[bytes]) -> Iterator[str]:
    """Path of a file in memory, as ``ssl`` takes keys from files alone."""
    memory = os.memfd_create("certificate")
    try:
        os.write(memory, b"\n".join(parts))
        yield f"/proc/self/fd/{memory}"
    finally:
        os.close(memory)


def first_reason(
    endpoints: Sequence[str], tls: Mapping[str, Any], user: str | None, *, is_key_known: bool = False
) -> NotLetIn:
    """Reason of the first address at which somebody listens, else of the first one; in 2 s."""
    found: list[NotLetIn] = []
    until_s = time.monotonic() + 1.0
    for endpoint in endpoints:
        found.append(why_not(endpoint, tls, user, is_key_known=is_key_known))
        if found[-1].why is not Why.AWAY or time.monotonic() > until_s:
            break
    if not found:
        return NotLetIn(Why.OTHER, "no address is given")
    return found[-1] if found[-1].why is not Why.AWAY else found[0]
