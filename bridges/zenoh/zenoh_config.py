"""Zenoh's configuration of a daemon, a router and a client: endpoints, TLS and access control.

Beside the signatures zenoh's own access control refuses at the door, by password and certificate. With no
users a daemon listens on this computer only.
"""

import ipaddress
import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import zenoh

from bridges.zenoh.keys import COMMAND, KEYS, PUBLISH, QUERY, expression, prefix
from bridges.zenoh.options import Options, TlsOptions
from bridges.zenoh.users import SecurityError, User
from hil.vocab.verbs import Role

MESSAGE_BYTES = 1 << 20
"""Maximum length that zenoh puts together from fragments; its own limit is 1 GiB for each client."""
ACCEPT_MS = 2000
"""Maximum time for a connection to say who it is. Zenoh accepts no other while it waits for 100 of them: 100
silent ones kept others out for 11 s with its own 10 s, and for 3 s with this (measured)."""
CONNECT_MS = 1000
"""Time of one attempt to reach the router; the bridge makes the next."""
CLOSE_US = 500_000
"""Silence after which a client that reads no answers loses its link: others wait for theirs meanwhile."""


def access_control(
    users: Sequence[User], bench: str, by: Literal["usrpwd", "tls"] = "usrpwd"
) -> dict[str, Any]:
    """Make zenoh's ``access_control`` for a daemon. Ingress is what clients send, egress what they are sent.

    With "tls" certificate and password both have to have the user's name.
    """
    ours = prefix(bench)

    def keys(way: str, *roles: Role) -> list[str]:
        wanted = roles or tuple(Role)
        found = [key.pattern for key in KEYS if way in key.way and key.role in wanted]
        return [expression(bench, pattern) for pattern in found]

    everything, live = [f"{ours}/**"], [f"{ours}/@live/**"]
    rules: list[tuple[Role, str, list[str], list[str]]] = [
        (Role.VIEWER, "ingress", ["declare_subscriber"], everything),
        (Role.VIEWER, "egress", ["put"], keys(PUBLISH)),
        (Role.VIEWER, "ingress", ["query"], keys(QUERY)),
        (Role.VIEWER, "egress", ["reply"], keys(QUERY)),
        # A querier or publisher that is declared stays silent while it knows of nobody at the other end.
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
    """True if only this computer reaches an endpoint, as in ``tcp/127.0.0.1:7447``."""
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
    "scouting/delay": 0,  # else opening a router waits 0.5 s for peers that nobody looks for
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
    """Make zenoh's configuration of a daemon: path in it to value. ``users`` are those of ``options.users``;
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
        raise SecurityError("tls: certificates have no roles; add `users`")
    if options.users and options.listen and options.connect:
        raise SecurityError(
            "connect: messages from a router have no user, so with `users` all would be refused;"
            " write `listen: []`, and let the router's access control decide, or leave out `connect`"
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
    """Make zenoh's configuration of a router that only joins others. With ``tls`` only certificates of the
    site are let in; permissions are each bench's, by signatures.

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


def made(entries: Mapping[str, Any]) -> zenoh.Config:
    """Convert a configuration to zenoh's own form."""
    config = zenoh.Config()
    for path, value in entries.items():
        config.insert_json5(path, json.dumps(value))
    return config


def client_config(
    connect: Sequence[str], user: str | None = None, secret: str | None = None, tls: TlsOptions | None = None
) -> dict[str, Any]:
    """Make zenoh's configuration of a client; with ``tls`` it needs the user's certificate and password."""
    config: dict[str, Any] = {**_CLOSED, "mode": "client", "connect/endpoints": list(connect)}
    if tls:
        config["transport/link/tls"] = _tls(tls)
    if user:
        config["transport/auth/usrpwd"] = {"user": user, "password": secret}
    return config
