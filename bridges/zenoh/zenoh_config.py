"""Zenoh's configuration of a daemon, a router and a client: endpoints, TLS and access control.

Beside the signatures zenoh's own access control refuses at the door, by password and certificate. With no
users a daemon listens on this computer only.
"""

import ipaddress
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import zenoh

from bridges.zenoh.access import Subject, access_control, access_of
from bridges.zenoh.keys import KEYS, QUERY, expression
from bridges.zenoh.options import Options, TlsOptions
from bridges.zenoh.site_folder import AUTHORITY, CERTIFICATE, KEY, SiteFolder
from bridges.zenoh.site_list import SiteList
from bridges.zenoh.users import SecurityError, User

MESSAGE_BYTES = 1 << 20
"""Maximum length that zenoh puts together from fragments; its own limit is 1 GiB for each client."""
PASSWORD = "transport/auth/usrpwd"
"""Path of name and password at a door. A door without users lets nobody in who has some (zenoh 1.10)."""
ACCEPT_MS = 2000
"""Maximum time for a connection to say who it is. Zenoh accepts no other while it waits for 100 of them: 100
silent ones kept others out for 11 s with its own 10 s, and for 3 s with this (measured)."""
CONNECT_MS = 1000
"""Time of one attempt to reach the router; the bridge makes the next."""
RETRY = {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2}
"""Times between attempts to reach a router that has gone: it is back 0.01 s after it took a new list, and
zenoh's own first attempt would be a second later."""
CLOSE_US = 500_000
"""Silence after which a client that reads no answers loses its link: others wait for theirs meanwhile."""


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


READINGS_HZ = 500.0
"""Maximum rate of the questions under one row of the table of keys that a router lets through from one
connection; more are dropped. A bench takes some thousand a second from all."""
SOCKET_BYTES = 1 << 17
"""Room for what is on its way in one direction of a connection. Behind a router all clients share one to the
bench, and in it a stop cannot pass the questions before it; the system's own room is some megabytes."""

_CLOSED: Mapping[str, Any] = {
    "transport/link/tcp/so_sndbuf": SOCKET_BYTES,
    "transport/link/tcp/so_rcvbuf": SOCKET_BYTES,
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
    rooms = {f"so_{way}buf": SOCKET_BYTES for way in ("snd", "rcv")}
    return (
        ends
        | rooms
        | {
            "root_ca_certificate": str(tls.ca.absolute()),
            "enable_mtls": True,
            "verify_name_on_connect": True,
            "close_link_on_expiration": True,
        }
    )


def site_options(options: Options, folder: SiteFolder) -> Options:
    """Options of a bench of a site, with the files of its folder; it joins the site's routers by default."""
    if options.users or options.tls:
        raise SecurityError("site: it has users and certificates; leave out `users` and `tls`")
    tls = TlsOptions(
        ca=folder.folder / AUTHORITY, certificate=folder.folder / CERTIFICATE, key=folder.folder / KEY
    )
    own: dict[str, Any] = {"tls": tls}
    if not {"listen", "connect"} & options.model_fields_set:
        own |= {"listen": [], "connect": list(folder.list.routers)}
    return options.model_copy(update=own)


def site_subjects(of: SiteList, bench: str = "") -> list[Subject]:
    """Members of a site, as zenoh's access control knows them: by the name in the certificate. ``bench``: the
    one bench that is here, at which others ask as users; empty at a router."""
    subjects = []
    for each in of.members.values():
        levels = of.levels(each)
        if bench:
            role = of.role_at(each, bench)
            levels = {bench: role} if role else {}
        is_bench = each.is_bench and not bench
        known_by = {"cert_common_names": [each.certified]}
        subjects.append(Subject(each.name, known_by, levels, each.name if is_bench else ""))
    return subjects


def session_config(
    options: Options, bench: str, users: Sequence[User], dictionary: str, site: SiteList | None = None
) -> dict[str, Any]:
    """Make zenoh's configuration of a daemon: path in it to value. ``users`` are those of ``options.users``;
    ``dictionary`` is the path of a file with their ``name:password`` lines, which zenoh reads while it opens.
    ``site``: the list of the site of ``options.site``, whose options are those of ``site_options``.

    Raises:
        SecurityError: strangers could reach the bench.
    """
    _refuse_open_doors(options)
    if options.listen:  # the router is looked for in the background
        how = {"mode": "router", "connect/exit_on_failure": False, "connect/timeout_ms": -1}
    else:
        # A router passes nothing on between peers, and between routers it forgets some after a restart: one
        # in ten was not seen any more (zenoh 1.10, measured). With clients neither happens.
        how = {
            "mode": "client" if options.connect else "peer",
            "connect/timeout_ms": CONNECT_MS,
            "connect/retry": RETRY,
        }
    config: dict[str, Any] = {
        **_CLOSED,
        **how,
        "listen/endpoints": list(options.listen),
        "connect/endpoints": list(options.connect),
    }
    if options.tls:
        config["transport/link/tls"] = _tls(options.tls)
    own = next((user for user in users if user.name == bench), None)
    if own and options.connect:
        config[PASSWORD] = {"user": own.name, "password": own.secret}
    if users and options.listen:
        config["access_control"] = access_control(users, bench, "tls" if options.tls else "usrpwd")
        config["transport/auth/usrpwd/dictionary_file"] = dictionary
    if site and options.listen:
        config["access_control"] = access_of(site_subjects(site, bench), bench)
    return config


def _refuse_open_doors(options: Options) -> None:
    if options.tls and not (options.users or options.site):
        raise SecurityError("tls: certificates have no roles; add `users`")
    if (options.users or options.site) and options.listen and options.connect:
        raise SecurityError(
            "connect: messages from a router have no user, so with `users` or `site` all would be refused;"
            " write `listen: []`, and let the router's access control decide, or leave out `connect`"
        )
    beyond = [endpoint for endpoint in options.listen if not is_loopback(endpoint)]
    if options.insecure or not beyond:
        return
    if not (options.users or options.site):
        raise SecurityError(
            f"listen: {beyond[0]} is reached from other computers, and anybody there could move the axes; add"
            " `site` (`hil zenoh site` makes all that is needed) or `users`, or listen on 127.0.0.1, or write"
            " `insecure: true`"
        )
    schemes = ("tls", "quic") if options.tls else ("tcp",)
    for endpoint in beyond:
        if endpoint.partition("/")[0] not in schemes:
            raise SecurityError(
                f"listen: {endpoint}: beyond this computer users are known by {' or '.join(schemes)} only;"
                f" write {schemes[0]}/ADDRESS:PORT"
            )


def router_config(
    listen: Sequence[str],
    tls: TlsOptions | None,
    is_insecure: bool,
    users: Sequence[User] = (),
    dictionary: str = "",
    site: SiteList | None = None,
) -> dict[str, Any]:
    """Make zenoh's configuration of a router that joins others. With ``users`` it lets in those alone, each
    bench to tell what is below its own name, and users to ask; with ``site`` its members. ``dictionary``:
    as of ``session_config``.

    Raises:
        SecurityError: strangers could reach it.
    """
    for endpoint in listen:
        if is_insecure or is_loopback(endpoint):
            continue
        if not (users or site):
            raise SecurityError(
                f"{endpoint} is reached from other computers, and anybody there could speak for a bench; name"
                " the router's folder of a site by --site (`hil zenoh site new` makes one), or"
                " write --insecure"
            )
        if not (tls and endpoint.startswith(("tls/", "quic/"))):
            raise SecurityError(
                f"{endpoint} is reached from other computers, and what goes there can be read; use tls/ with"
                " --ca, --certificate and --key, or --insecure"
            )
    config: dict[str, Any] = {
        **_CLOSED,
        "mode": "router",
        "listen/endpoints": list(listen),
        "downsampling": [
            {
                "id": "readings",
                "flows": ["ingress"],
                "messages": ["query"],
                "rules": [
                    {"key_expr": expression("*", key.pattern), "freq": READINGS_HZ}
                    for key in KEYS
                    if QUERY in key.way
                ],
            }
        ],
    }
    if tls:
        config["transport/link/tls"] = _tls(tls)
    if users:
        config["access_control"] = access_control(users, "*", "tls" if tls else "usrpwd")
        config["transport/auth/usrpwd/dictionary_file"] = dictionary
    if site:
        config["access_control"] = access_of(site_subjects(site), "*")
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
        config[PASSWORD] = {"user": user, "password": secret}
    return config


@contextmanager
def password_file(users: Sequence[User]) -> Iterator[str]:
    """Path of the file that zenoh wants passwords in. It is in memory, and gone afterwards."""
    memory = os.memfd_create("users")
    try:
        os.write(memory, "".join(f"{user.name}:{user.secret}\n" for user in users).encode())
        yield f"/proc/self/fd/{memory}"
    finally:
        os.close(memory)


def opened(entries: Mapping[str, Any]) -> zenoh.Session:
    """Open a session; at a door without users its name and password are left out, which keep it out there.

    Raises:
        zenoh.ZError: it cannot be opened.
    """
    try:
        return zenoh.open(made(entries))
    except zenoh.ZError:
        if PASSWORD not in entries:
            raise
        return zenoh.open(made({path: value for path, value in entries.items() if path != PASSWORD}))
