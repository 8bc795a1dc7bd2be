"""Folder of a whole site, where its authority's key is: members are made, changed, removed, renewed. Each
change makes a new list, with the next number, and puts it into the folders of all members."""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from bridges.zenoh.site_certificates import (
    Pair,
    check_host,
    door,
    hosts_of,
    issued,
    key_pem,
    made_authority,
    need_cryptography,
    nested,
    new_key,
    write_new,
    write_whole,
)
from bridges.zenoh.site_folder import (
    AUTHORITY,
    CERTIFICATE,
    KEY,
    LIST,
    SITE_KEY,
    checked_list,
    read_certificates,
    read_file,
    refuse_open,
    signed_list,
)
from bridges.zenoh.site_list import ROUTER, RoleGrant, SiteList, SiteMember, check_name
from bridges.zenoh.users import SecurityError
from bridges.zenoh.zenoh_config import RETRY, client_config
from hil.net.signature import read_key

PRIVATE = "site.key"
"""Key that signs lists, and, where the site has an authority of its own, certificates too."""
AUTHORITY_DAYS = 3650


def new_site(
    folder: Path, name: str, routers: Sequence[str], port: int, now: datetime, days: int, ca: Path | None
) -> "SiteAuthority":
    """Make a site in a new or empty folder. ``routers``: names and addresses of the router's computer;
    ``ca``: certificates of an authority that exists, which then issues all others.

    Raises:
        SecurityError: there are files already, or a name does not do.
    """
    need_cryptography()
    check_name(name, is_bench=True)
    for host in routers:
        check_host(host)
    authorities = read_certificates(ca) if ca else []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise SecurityError(f"{folder} is not empty, and nothing is overwritten; name another folder")
        folder.chmod(0o700)
        own = None if authorities else made_authority(name, now, AUTHORITY_DAYS)
        key = own.key if own else new_key()
        write_new(folder / PRIVATE, key_pem(key))
        write_new(folder / SITE_KEY, _public_pem(key), 0o644)
        write_new(folder / AUTHORITY, _pem(*([own.certificate] if own else authorities)), 0o644)
        first = SiteList(name, 1, [door(host, port) for host in routers])
        write_new(folder / LIST, signed_list(first, key), 0o644)
        site = SiteAuthority(folder)
        if routers:
            site.make_folder(ROUTER, ROUTER, routers, now, days)
    except OSError as error:
        raise SecurityError(f"{error.filename or folder}: {error.strerror}") from None
    return site


class SiteAuthority:
    """Folder of a site. ``list`` is its newest; ``is_own``: it issues certificates itself.

    Raises:
        SecurityError: it is none, or cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        need_cryptography()
        self.folder = folder
        if not (folder / PRIVATE).exists():
            raise SecurityError(
                f"{folder}: there is no {PRIVATE}; `hil zenoh site new` makes a site's folder"
            )
        refuse_open(folder / PRIVATE)
        self._key = read_key(read_file(folder / PRIVATE), True, str(folder / PRIVATE), SecurityError)
        self._authority = read_certificates(folder / AUTHORITY)[0]
        self.is_own = self._authority.public_key() == self._key.public_key()
        path = folder / LIST
        self.list = checked_list(read_file(path), self._key.public_key(), str(path))

    def place(self, name: str) -> Path:
        """Folder of a member, or of the router."""
        if name == ROUTER:
            return self.folder / ROUTER
        return self.folder / ("benches" if self.list.members[name].is_bench else "users") / name

    def add_benches(
        self,
        names: Sequence[str],
        labels: Mapping[str, str],
        hosts: Sequence[str],
        now: datetime,
        days: int,
    ) -> None:
        """Add benches. ``hosts``: names and addresses of a bench to which clients connect without a
        router."""
        for host in hosts:
            check_host(host)
        if not (hosts or self.list.routers):
            raise SecurityError("the site has no router; write --host, where clients connect to the bench")
        self._add([self._new(name, labels=labels, is_bench=True) for name in names], hosts, now, days)

    def add_user(self, name: str, grants: Sequence[RoleGrant], now: datetime, days: int) -> None:
        """Add a user."""
        self._add([self._new(name, grants=grants)], (), now, days)

    def _new(self, name: str, **more: Any) -> SiteMember:
        check_name(name, more.get("is_bench", False))
        for other in self.list.members.values():
            if other.name.lower() == name.lower():
                kind = "bench" if other.is_bench else "user"
                raise SecurityError(
                    f"{name}: the {kind} {other.name} is there already; take another name, or"
                    " change that one:"
                    " `hil zenoh site change`"
                )
        return SiteMember(name, self.list.certified_name(name), **more)

    def _add(self, members: Sequence[SiteMember], hosts: Sequence[str], now: datetime, days: int) -> None:
        changed = self.list
        for member in members:
            if member.name in changed.members and member.name not in self.list.members:
                raise SecurityError(f"{member.name}: the name is there twice; write it once")
            changed = changed.with_member(member)
        self._change(changed)
        for member in members:
            self.make_folder(member.name, member.certified, hosts, now, days)

    def change(
        self, name: str, grants: Sequence[RoleGrant] | None = None, labels: Mapping[str, str] | None = None
    ) -> None:
        """Give a user other roles, or a bench other labels, in the place of those that it has."""
        member = self.member(name)
        if grants is not None and member.is_bench:
            raise SecurityError(f"{name} is a bench; roles are for users")
        if labels is not None and not member.is_bench:
            raise SecurityError(f"{name} is a user; labels are for benches")
        more: dict[str, Any] = {"grants": grants} if grants is not None else {}
        more |= {"labels": labels} if labels is not None else {}
        self._change(self.list.with_member(replace(member, **more)))

    def remove(self, names: Sequence[str]) -> None:
        """Remove members, and their folders here; their certificates are revoked."""
        changed, places = self.list, []
        for name in names:
            member = self.member(name)
            places.append(self.place(member.name))
            changed = changed.without(name, self._serials(places[-1]))
        for place in places:
            shutil.rmtree(place, ignore_errors=True)
        self._change(changed)

    def rotate(self, names: Sequence[str], now: datetime, days: int, is_stolen: bool = False) -> list[str]:
        """Give members, by default all and the router, new keys and certificates; answers whom.
        ``is_stolen``: the certificates before are revoked."""
        if is_stolen and ROUTER in names:
            raise SecurityError(
                "a router's certificate cannot be revoked, as clients read no list; make the site's"
                " router new"
                " under another name of its computer, or the site"
            )
        if not self.is_own and not is_stolen:
            raise SecurityError(
                f"the certificates are from another authority; renew them there, and write {CERTIFICATE} and"
                f" {KEY} into the folders: routers and benches take them while they run"
            )
        chosen = list(names) or [*([ROUTER] if self.place(ROUTER).exists() else []), *self.list.members]
        changed = self.list
        for name in chosen:
            if name != ROUTER:
                member, place = self.member(name), self.place(name)
                if is_stolen:
                    changed = changed.without(name, self._serials(place))
                    changed = changed.with_member(replace(member, certified=changed.certified_name(name)))
        self._change(changed)
        for name in chosen:
            certified = ROUTER if name == ROUTER else self.list.members[name].certified
            place = self.place(name)
            hosts = hosts_of(read_certificates(place / CERTIFICATE)[0]) if self.is_own else ()
            self.make_folder(name, certified, hosts, now, days)
        return chosen

    def member(self, name: str) -> SiteMember:
        """Member of a name. Raises SecurityError: there is none."""
        if name not in self.list.members:
            there = ", ".join(self.list.members) or "nobody"
            raise SecurityError(f"{name}: the site {self.list.site} has no such member; there: {there}")
        return self.list.members[name]

    def make_folder(self, name: str, certified: str, hosts: Sequence[str], now: datetime, days: int) -> None:
        """Make or renew the folder of a member with what it needs, and nothing of others."""
        place = self.place(name)
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        if self.is_own:
            pair = issued(Pair(self._authority, self._key), certified, now, days, hosts)
            certificate, key = pair.pem()
            write_whole(place / KEY, key)
            write_whole(place / CERTIFICATE, certificate, 0o644)
        is_user = name != ROUTER and not self.list.members[name].is_bench
        for file in (AUTHORITY,) if is_user else (AUTHORITY, SITE_KEY, LIST):
            write_whole(place / file, read_file(self.folder / file), 0o644)
        if is_user:
            doors = list(self.list.routers) or self._doors_of_benches()
            config = json.dumps(nested(_client(name, doors)), indent=1)
            write_whole(place / "zenoh.json", config.encode(), 0o644)

    def _doors_of_benches(self) -> list[str]:
        """Addresses of benches that listen, in a site without a router."""
        hosts = [hosts_of(read_certificates(self.place(each.name) / CERTIFICATE)[0])
                 for each in self.list.benches if self.is_own]  # fmt: skip
        return [door(each[0], 7447) for each in hosts if each]

    def _change(self, changed: SiteList) -> None:
        """Sign the next list, and put it into all folders."""
        self.list = replace(changed, number=self.list.number + 1)
        content = signed_list(self.list, self._key)
        write_whole(self.folder / LIST, content, 0o644)
        for name in (ROUTER, *(each.name for each in self.list.benches)):
            if (place := self.place(name)).is_dir():
                write_whole(place / LIST, content, 0o644)

    def _serials(self, place: Path) -> list[str]:
        path = place / CERTIFICATE
        return [f"{read_certificates(path)[0].serial_number:x}"] if path.exists() else []


def _client(user: str, doors: Sequence[str]) -> dict[str, Any]:
    """Zenoh's configuration of a user; names of files are relative to its folder."""
    return client_config(doors) | {
        "metadata": {"name": user},
        "connect/retry": RETRY,
        "transport/link/tls": {
            "root_ca_certificate": AUTHORITY,
            "connect_certificate": CERTIFICATE,
            "connect_private_key": KEY,
            "enable_mtls": True,
            "verify_name_on_connect": True,
        },
    }


def _pem(*certificates: Any) -> bytes:
    from cryptography.hazmat.primitives.serialization import Encoding

    return b"".join(each.public_bytes(Encoding.PEM) for each in certificates)


def _public_pem(key: Any) -> bytes:
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

    text: bytes = key.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)
    return text
