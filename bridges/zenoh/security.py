"""Who may: users with roles, the signature on a command, and what zenoh itself is told to let through.

Zenoh tells a program nothing about who sent a message. So each command carries a signature
(``hil.net.signature``), which ``Gate`` checks. Beside it zenoh's own access control refuses at the door, by
password and certificate. With no users the bridge listens on this computer only.
"""

import errno
import heapq
import hmac
import ipaddress
import json
import os
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import zenoh

from bridges.zenoh.keys import COMMAND, KEYS, PUBLISH, QUERY, prefix
from bridges.zenoh.options import Options, TlsOptions
from hil.net.signature import mac_of
from hil.vocab.bridges import Source
from hil.vocab.verbs import Role, VerbRefused
from hil.wire.json_text import JsonError, read_json

FRESH_NS = 30_000_000_000
"""How far a signature's time may be from the daemon's, either way: clocks of a site differ by seconds."""
REMEMBERED = 65_536
"""Nonces of one user: 2000 commands a second for as long as a signature is fresh."""
SECRET_CHARACTERS = 12
"""At least. Whoever hears the wire without TLS can try passwords on what was heard."""
ATTACHMENT_BYTES = 1024
_FILE_CHARACTERS = 1 << 20
MESSAGE_BYTES = 1 << 20
"""Longest that zenoh puts together from fragments; its own limit is 1 GiB for each client."""
ACCEPT_MS = 2000
"""For a connection to say who it is. Zenoh accepts nobody while it waits for 100 of them: with its own 10 s,
100 that said nothing kept others out for 11 s, and with this for 3 s (measured)."""
CONNECT_MS = 1000
"""For one attempt to reach the router; the bridge makes the next."""
CLOSE_US = 500_000
"""A client that reads nothing of its answers for so long loses its link: others wait for theirs meanwhile."""
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")
_NONCE = re.compile(r"[0-9a-f]{16,64}")
_MAC = re.compile(r"[0-9a-f]{64}")


class SecurityError(Exception):
    """The bridge cannot be opened safely: ``str(error)`` says why and what to do."""


class Rejected(VerbRefused):
    """A signature does not do."""

    def __init__(self, why: str) -> None:
        super().__init__("forbidden", why)


@dataclass(frozen=True)
class User(Source):
    """Of the users' file. The secret is the password at zenoh's door and the key of signatures."""

    secret: str = field(repr=False)


def read_users(path: Path) -> list[User]:
    """The users of a file: a line ``name:role:password`` for each; ``#`` begins a line that is skipped.

    Raises:
        SecurityError: it cannot be read, others can read it, or lines are wrong; with all of them.
    """
    try:
        _refuse_endless(path)
        with path.open(encoding="utf-8") as file:
            mode = os.fstat(file.fileno()).st_mode & 0o777
            lines = file.read(_FILE_CHARACTERS).splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SecurityError(f"{path}: {error}; `hil zenoh keys` makes such a file") from None
    if mode & 0o077:
        raise SecurityError(f"{path}: others can read it (mode {mode:04o}); chmod 600 {path}")
    users = parse_users(lines, str(path))
    if not users:
        raise SecurityError(f"{path}: there is no user; write lines like anna:operator:PASSWORD")
    return users


def _refuse_endless(path: Path) -> None:
    """A FIFO, a device and what is below /proc may have no end, or none soon.

    Raises:
        OSError: it is one of those, or not there.
    """
    if not path.is_dir() and not (path.is_file() and path.stat().st_size) and path.exists():
        raise OSError(errno.EINVAL, "it is empty, or no regular file")


def parse_users(lines: Sequence[str], where: str) -> list[User]:
    """The same of lines. ``where`` stands before a line's number in errors."""
    users: list[User] = []
    problems = []
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            users.append(_user(line, users))
        except ValueError as error:
            problems.append(f"{where}:{number}: {error}")
    if problems:
        raise SecurityError("\n".join(problems))
    return users


def _user(line: str, before: Sequence[User]) -> User:
    name, _, rest = line.partition(":")
    role, _, secret = rest.partition(":")
    if not secret:
        raise ValueError("write name:role:password")
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is no name: letters, digits, _ . - and at most 64 of them")
    roles = {each.name.lower(): each for each in Role}
    if role not in roles:
        raise ValueError(f"there is no role {role!r}; there are {', '.join(roles)}")
    if len(secret) < SECRET_CHARACTERS or not secret.isprintable() or secret != secret.strip():
        raise ValueError(
            f"the password needs {SECRET_CHARACTERS} printable characters or more, no space around"
        )
    if any(name == other.name for other in before):
        raise ValueError(f"{name} is there twice")
    if any(secret == other.secret for other in before):
        raise ValueError(f"{name} has the password of another: a signature would be either's")
    return User(name, roles[role], secret)


# ---- the signature on a command ----


class _Seen:
    """Nonces of one user. Where there are too many, the oldest goes, and whatever is as old is refused."""

    def __init__(self) -> None:
        self._nonces: set[str] = set()
        self._by_time: list[tuple[int, str]] = []
        self._floor_ns = 0

    def add(self, nonce: str, at_ns: int, now_ns: int) -> None:
        if nonce in self._nonces or at_ns <= self._floor_ns:
            raise Rejected("the signature was used before: sign each command anew")
        while self._by_time and (self._by_time[0][0] < now_ns - FRESH_NS or len(self._by_time) >= REMEMBERED):
            gone_ns, gone = heapq.heappop(self._by_time)
            self._floor_ns = max(self._floor_ns, gone_ns)
            self._nonces.discard(gone)
        self._nonces.add(nonce)
        heapq.heappush(self._by_time, (at_ns, nonce))


class Gate:
    """Checks who sent a command. ``since_ns``: what was signed before is refused, for nonces from then are
    not remembered."""

    def __init__(self, users: Sequence[User], since_ns: int = 0) -> None:
        self._since_ns = since_ns
        self._users = {user.name: user for user in users}
        self._seen = {user.name: _Seen() for user in users}

    def secret_of(self, name: str) -> str | None:
        """Of a user, to sign for."""
        return self._users[name].secret if name in self._users else None

    def check(self, attachment: bytes | None, key: str, payload: bytes, now_ns: int) -> User:
        """Who signed it. ``now_ns`` is wall time.

        Raises:
            Rejected: nobody known did, or not just now, or it was here before.
        """
        name, at_ns, nonce, mac = _read_attachment(attachment)
        user = self._users.get(name)
        # The work is the same for a name that does not exist, and so is the answer.
        expected = mac_of(user.secret if user else "", key, payload, at_ns, nonce)
        if not hmac.compare_digest(expected, mac) or user is None or "\n" in key:
            raise Rejected("the signature is wrong: check user, password, key and payload")
        if abs(now_ns - at_ns) > FRESH_NS:
            off_s = (now_ns - at_ns) / 1e9
            how = f"{off_s:.1f} s old" if off_s > 0 else f"of {-off_s:.1f} s from now"
            raise Rejected(f"the signature is {how}; compare the clocks of both computers")
        if at_ns < self._since_ns:
            raise Rejected("the signature is from before the daemon's start; sign the command anew")
        self._seen[name].add(nonce, at_ns, now_ns)
        return user


def _read_attachment(attachment: bytes | None) -> tuple[str, int, str, str]:
    if not attachment:
        raise Rejected("the command is not signed: its attachment has to have user, at_ns, nonce and mac")
    try:
        given = read_json(attachment) if len(attachment) <= ATTACHMENT_BYTES else None
    except JsonError:
        given = None
    match given:
        case {"user": str(name), "at_ns": int(at_ns), "nonce": str(nonce), "mac": str(mac)}:
            if _NONCE.fullmatch(nonce) and _MAC.fullmatch(mac) and 0 <= at_ns < 1 << 63:
                return name, at_ns, nonce, mac
    raise Rejected('the attachment has to be {"user": NAME, "at_ns": WALL, "nonce": HEX, "mac": HEX}')


# ---- what zenoh is told ----


def access_control(
    users: Sequence[User], bench: str, by: Literal["usrpwd", "tls"] = "usrpwd"
) -> dict[str, Any]:
    """Zenoh's ``access_control`` for a daemon. Ingress is what clients send, egress what they are sent.

    With "tls" somebody is a user whose certificate and password both have the user's name.
    """
    ours = prefix(bench)

    def keys(way: str, *roles: Role) -> list[str]:
        wanted = roles or tuple(Role)
        found = [key.pattern for key in KEYS if way in key.way and key.role in wanted]
        return [f"{ours}/{re.sub('<[a-z]+>', '*', pattern)}" for pattern in found]

    everything, live = [f"{ours}/**"], [f"{ours}/@live/**"]
    rules: list[tuple[Role, str, list[str], list[str]]] = [
        (Role.VIEWER, "ingress", ["declare_subscriber"], everything),
        (Role.VIEWER, "egress", ["put"], keys(PUBLISH)),
        (Role.VIEWER, "ingress", ["query"], keys(QUERY)),
        (Role.VIEWER, "egress", ["reply"], keys(QUERY)),
        # A declared querier or publisher of zenoh is silent while it knows of nobody at the other end.
        (Role.VIEWER, "egress", ["declare_queryable"], everything),
        (Role.OPERATOR, "egress", ["declare_subscriber"], everything),
        (Role.VIEWER, "ingress", ["liveliness_query", "declare_liveliness_subscriber"], live),
        (Role.VIEWER, "egress", ["liveliness_token"], live),
    ]
    for role in (Role.OPERATOR, Role.ADMIN):
        rules += [
            (role, "ingress", ["put", "query"], keys(COMMAND, role)),
            (role, "egress", ["reply"], keys(COMMAND, role)),
        ]

    def subject(user: User) -> dict[str, Any]:
        named = {"id": user.name, "usernames": [user.name]}
        return named | {"cert_common_names": [user.name]} if by == "tls" else named

    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [
            {"id": f"{n}", "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": on}
            for n, (_, flow, messages, on) in enumerate(rules)
        ],
        "subjects": [subject(user) for user in users],
        "policies": [
            {
                "rules": [f"{n}" for n, (needed, *_) in enumerate(rules) if user.role >= needed],
                "subjects": [user.name],
            }
            for user in users
        ],
    }


def is_loopback(endpoint: str) -> bool:
    """Whether only this computer reaches an endpoint, as in ``tcp/127.0.0.1:7447``."""
    scheme, _, rest = endpoint.partition("/")
    if scheme in ("unixsock-stream", "unixpipe"):
        return True
    host = re.split(r"[?#]", rest)[0].rpartition(":")[0].strip("[]")
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


_CLOSED: Mapping[str, Any] = {
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "scouting/delay": 0,  # else a router's open waits 0.5 s for whom nobody looks
    "adminspace/enabled": False,
    "plugins_loading/enabled": False,
    "transport/shared_memory/enabled": False,
    "transport/unicast/max_links": 1,  # zenoh's access control looks at one link of each client only
    "transport/unicast/accept_timeout": ACCEPT_MS,
    "transport/link/rx/max_message_size": MESSAGE_BYTES,
    "transport/link/tx/queue/congestion_control/block/wait_before_close": CLOSE_US,
    "timestamping/enabled": False,
}


def _tls(tls: TlsOptions) -> dict[str, Any]:
    ends = {
        f"{end}_{what}": str(path.absolute())
        for end in ("listen", "connect")
        for what, path in (("certificate", tls.certificate), ("private_key", tls.key))
    }
    return ends | {
        "root_ca_certificate": str(tls.ca.absolute()),
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
    }


def session_config(options: Options, bench: str, users: Sequence[User], dictionary: str) -> dict[str, Any]:
    """Zenoh's configuration of a daemon: path in it to value. ``users`` are those of ``options.users``;
    ``dictionary`` is the path of a file with their ``name:password`` lines, which zenoh reads while it opens.

    Raises:
        SecurityError: strangers could reach the bench.
    """
    _refuse_open_doors(options)
    if options.listen:  # the router is looked for in the background
        how = {"mode": "router", "connect/exit_on_failure": False, "connect/timeout_ms": -1}
    else:
        # A router passes nothing on between peers, and between routers it forgets some after a restart: one
        # in ten was not seen any more (zenoh 1.10, measured). With clients neither happens.
        how = {"mode": "client" if options.connect else "peer", "connect/timeout_ms": CONNECT_MS}
    config: dict[str, Any] = {
        **_CLOSED,
        **how,
        "listen/endpoints": list(options.listen),
        "connect/endpoints": list(options.connect),
    }
    if options.tls:
        config["transport/link/tls"] = _tls(options.tls)
    if users and options.listen:
        config["access_control"] = access_control(users, bench, "tls" if options.tls else "usrpwd")
        config["transport/auth/usrpwd/dictionary_file"] = dictionary
    return config


def _refuse_open_doors(options: Options) -> None:
    if options.tls and not options.users:
        raise SecurityError("tls: certificates say who, not what each may; add `users`")
    if options.users and options.listen and options.connect:
        raise SecurityError(
            "connect: what comes from a router has no user here, so with `users` nothing of it would pass;"
            " write `listen: []`, and let the router's access control decide, or leave `connect` away"
        )
    beyond = [endpoint for endpoint in options.listen if not is_loopback(endpoint)]
    if options.insecure or not beyond:
        return
    if not options.users:
        raise SecurityError(
            f"listen: {beyond[0]} is reached from other computers, and anybody there could move the axes; add"
            " `users` (`hil zenoh keys` makes all that is needed), or listen on 127.0.0.1, or write"
            " `insecure: true`"
        )
    schemes = ("tls", "quic") if options.tls else ("tcp",)
    for endpoint in beyond:
        if endpoint.partition("/")[0] not in schemes:
            raise SecurityError(
                f"listen: {endpoint}: beyond this computer users are known by {' or '.join(schemes)} only;"
                f" write {schemes[0]}/ADDRESS:PORT"
            )


def router_config(listen: Sequence[str], tls: TlsOptions | None, is_insecure: bool) -> dict[str, Any]:
    """The same of a router that only joins others. With ``tls`` who has no certificate of the site stays
    out; what each may do its bench decides by signatures.

    Raises:
        SecurityError: strangers could reach it.
    """
    for endpoint in listen:
        if is_insecure or is_loopback(endpoint) or (tls and endpoint.startswith(("tls/", "quic/"))):
            continue
        raise SecurityError(
            f"{endpoint} is reached from other computers, and anybody there could join; use tls/ with --ca,"
            " --certificate and --key, or --insecure"
        )
    config: dict[str, Any] = {**_CLOSED, "mode": "router", "listen/endpoints": list(listen)}
    if tls:
        config["transport/link/tls"] = _tls(tls)
    return config


def open_session(options: Options, bench: str) -> tuple[zenoh.Session, Gate | None]:
    """A daemon's session, and what checks its commands; None: there are no users, everybody may do all.

    Raises:
        SecurityError: strangers could reach the bench, or the users' file is wrong.
        zenoh.ZError: an address is taken, a certificate cannot be read.
    """
    users = read_users(options.users) if options.users else []
    for path in (options.tls.ca, options.tls.certificate, options.tls.key) if options.tls else ():
        try:
            _refuse_endless(path)
            path.open("rb").close()  # zenoh would only say that nobody is there
        except OSError as error:
            why = f"cannot be read: {error.strerror}"
            raise SecurityError(f"tls: {path} {why}; `hil zenoh keys` makes such files") from None
    # Zenoh wants passwords in a file. This one is in memory, of this process, and gone afterwards.
    memory = os.memfd_create("users")
    try:
        os.write(memory, "".join(f"{user.name}:{user.secret}\n" for user in users).encode())
        entries = session_config(options, bench, users, f"/proc/self/fd/{memory}")
        return zenoh.open(made(entries)), Gate(users, time.time_ns()) if users else None
    finally:
        os.close(memory)


def made(entries: Mapping[str, Any]) -> zenoh.Config:
    """Zenoh's own form of a configuration."""
    config = zenoh.Config()
    for path, value in entries.items():
        config.insert_json5(path, json.dumps(value))
    return config


def client_config(
    connect: Sequence[str],
    user: str | None = None,
    secret: str | None = None,
    tls: TlsOptions | None = None,
) -> dict[str, Any]:
    """The same of a client; with ``tls`` the user's certificate is needed beside the password."""
    config: dict[str, Any] = {**_CLOSED, "mode": "client", "connect/endpoints": list(connect)}
    if tls:
        config["transport/link/tls"] = _tls(tls)
    if user:
        config["transport/auth/usrpwd"] = {"user": user, "password": secret}
    return config
