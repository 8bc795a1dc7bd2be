"""Certificates of a small site: an authority, a daemon's certificate, and for each user certificate, password
and configuration. ``cli.py`` is their command."""

import base64
import json
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from bridges.zenoh.access import certified
from bridges.zenoh.site_certificates import (
    Pair,
    anywhere,
    check_host,
    door,
    issued,
    made_authority,
    need_cryptography,
    nested,
    write_new,
    write_pair,
)
from bridges.zenoh.site_list import BENCH_NAME
from bridges.zenoh.users import BENCH, SecurityError, parse_users
from bridges.zenoh.zenoh_config import client_config
from hil.vocab.verbs import Role


@dataclass(frozen=True)
class Site:
    """Site to make. ``hosts``: names and addresses of the daemon's computer; clients connect to the first.
    ``now`` has a time zone."""

    bench: str
    hosts: Sequence[str]
    users: Sequence[tuple[str, Role]]
    now: datetime
    days: int = 365
    port: int = 7447
    more: Sequence[str] = ()
    """Further benches, behind the same router; they share files and certificate."""
    routers: Sequence[str] = ()
    """Names and addresses of the router's computer, to which benches and clients connect."""

    @property
    def benches(self) -> Sequence[str]:
        return self.bench, *self.more


def make_site(folder: Path, site: Site) -> str:
    """Write all files into a new or empty folder; answers the lines for the bench's configuration.

    Raises:
        SecurityError: there are files already, a name does not do, or ``cryptography`` is not there.
    """
    need_cryptography()
    _check(site)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise SecurityError(f"{folder} is not empty, and nothing is overwritten; name another folder")
        folder.chmod(0o700)
        return _write_site(folder.absolute(), site)
    except OSError as error:
        raise SecurityError(f"{error.filename or folder}: {error.strerror}") from None


def _check(site: Site) -> None:
    """Refuse names that would make certificates that nobody can use."""
    for bench in site.benches:
        if not BENCH_NAME.fullmatch(bench):
            raise SecurityError(
                f"--bench {bench!r}: a bench's name is a letter a-z and up to 31 of a-z, 0-9, _, -"
            )
    if not (site.hosts or site.routers):
        raise SecurityError(
            "--host or --router: write where clients connect, the bench's computer or a router's"
        )
    if site.more and not site.routers:
        raise SecurityError("--bench: several benches join a router; write --router, or make a site for each")
    for host in (*site.hosts, *site.routers):
        check_host(host)
    names = [name.lower() for name, _ in site.users] + list(site.benches)
    if "ca" in names:
        raise SecurityError("--user ca: that is the authority's name; take another")
    if twice := {name for name in names if names.count(name) > 1}:
        raise SecurityError(f"--user {min(twice)}: that name is there twice")


def _write_site(folder: Path, site: Site) -> str:
    passwords = {name: secrets.token_urlsafe(24) for name, _ in site.users}
    lines = [f"{name}:{role.name.lower()}:{passwords[name]}" for name, role in site.users]
    lines += [f"{bench}:{BENCH}:{secrets.token_urlsafe(24)}" for bench in site.benches]
    parse_users(lines, "users")
    authority = made_authority(site.bench, site.now, site.days)
    daemon = issued(authority, certified(site.bench), site.now, site.days, site.hosts)
    owns = {name: issued(authority, name, site.now, site.days) for name, _ in site.users}

    write_new(folder / "users", "\n".join(lines).encode() + b"\n")
    write_pair(folder, "ca", authority)
    write_pair(folder, "daemon", daemon)
    if site.routers:
        router = issued(authority, "hil router", site.now, site.days, site.routers)
        write_pair(folder, "router", router)
    for name, own in owns.items():
        of_user = folder / "clients" / name
        of_user.mkdir(parents=True, mode=0o700)
        write_new(of_user / "ca.pem", authority.pem()[0], mode=0o644)
        write_pair(of_user, name, own)
        config = _client(site, name, passwords[name], authority, own)
        write_new(of_user / "zenoh.json", json.dumps(config, indent=1).encode())
    snippet = _snippet(folder, site)
    write_new(folder / "bridge.yaml", snippet.encode(), mode=0o644)
    return snippet


def _client(site: Site, user: str, password: str, authority: Pair, own: Pair) -> dict[str, Any]:
    """Make a zenoh configuration that needs no other file. The password is what commands are signed with."""

    def text(pem: bytes) -> str:
        return base64.b64encode(pem).decode()

    certificate, key = own.pem()
    entries = client_config([_door(site)], user, password) | {
        "transport/link/tls": {
            "root_ca_certificate_base64": text(authority.pem()[0]),
            "connect_certificate_base64": text(certificate),
            "connect_private_key_base64": text(key),
            "enable_mtls": True,
            "verify_name_on_connect": True,
        }
    }
    return nested(entries)


def _door(site: Site) -> str:
    """Address to which clients connect."""
    return door([*site.routers, *site.hosts][0], site.port)


def router_command(folder: Path, site: Site) -> str:
    """Command that runs the site's router."""
    of = folder.absolute()
    files = f"--ca {of}/ca.pem --certificate {of}/router.pem --key {of}/router.key --users {of}/users"
    return f"hil zenoh router --listen tls/{anywhere(site.routers)}:{site.port} {files}"


def _snippet(folder: Path, site: Site) -> str:
    listens = f'    listen: ["tls/{anywhere(site.hosts)}:{site.port}"]\n'
    if site.routers:
        listens = f'    listen: []\n    connect: ["{_door(site)}"]\n'
    return (
        "bridges:\n"
        "  zenoh:\n"
        f"{listens}"
        f"    users: {json.dumps(str(folder / 'users'))}\n"
        "    tls:\n"
        f"      ca: {json.dumps(str(folder / 'ca.pem'))}\n"
        f"      certificate: {json.dumps(str(folder / 'daemon.pem'))}\n"
        f"      key: {json.dumps(str(folder / 'daemon.key'))}\n"
    )
