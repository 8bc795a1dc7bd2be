"""List of a site's members: benches with labels, users with roles, what was revoked. Signed by the site's key
(``site_folder.py``), it is all that routers and benches need to know of others."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from bridges.zenoh.users import SecurityError
from hil.vocab.bench_labels import LABEL_CHARACTERS, is_label_value
from hil.vocab.verbs import Role
from hil.wire.json_text import JsonError, read_json

LIST_VERSION = 1
EVERYWHERE = "*"
ROUTER = "router"
"""Name of the router's folder and certificate; no member has it."""
BENCH_NAME = re.compile(r"[a-z][a-z0-9_-]{0,31}")
USER_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")
_LABEL_NAME = re.compile(r"[a-z][a-z0-9_-]{0,31}")
_SERIAL = re.compile(r"[0-9a-f]{1,40}")
_DOOR = re.compile(r"(tls|quic)/[^/\s]+:[0-9]{1,5}")
_ROLES = {role.name.lower(): role for role in Role}


@dataclass(frozen=True)
class RoleGrant:
    """Role of a user at some benches. ``where``: ``*`` for all, a bench's name, or a label ``rig=press``."""

    role: Role
    where: str = EVERYWHERE

    def __str__(self) -> str:
        role = self.role.name.lower()
        return role if self.where == EVERYWHERE else f"{role}@{self.where}"


@dataclass(frozen=True)
class SiteMember:
    """Bench or user. ``certified``: name in its certificate. ``labels`` are a bench's, ``grants`` a
    user's."""

    name: str
    certified: str
    is_bench: bool = False
    labels: Mapping[str, str] = field(default_factory=dict)
    grants: Sequence[RoleGrant] = ()


@dataclass(frozen=True)
class SiteList:
    """All of a site. ``number`` grows with each change. ``revoked``: serial numbers of certificates, as
    hexadecimal. ``spent``: by member the number of names in certificates that are not good any more."""

    site: str
    number: int
    routers: Sequence[str] = ()
    """Endpoints of routers, as ``tls/hub.lan:7447``."""
    members: Mapping[str, SiteMember] = field(default_factory=dict)
    revoked: frozenset[str] = frozenset()
    spent: Mapping[str, int] = field(default_factory=dict)

    @property
    def benches(self) -> list[SiteMember]:
        return [each for each in self.members.values() if each.is_bench]

    @property
    def users(self) -> list[SiteMember]:
        return [each for each in self.members.values() if not each.is_bench]

    def by_certificate(self, certified: str) -> SiteMember | None:
        """Member whose certificate has this name; None: there is none."""
        return self._certified.get(certified)

    @cached_property
    def _certified(self) -> dict[str, SiteMember]:
        return {each.certified: each for each in self.members.values()}

    def was_there(self, certified: str) -> bool:
        """True if a name in certificates is not good any more, as its member was removed or got another."""
        name, _, count = certified.partition("+")
        return (int(count) if count.isdecimal() else 1) <= self.spent.get(name, 0)

    def levels(self, user: SiteMember) -> dict[str, Role]:
        """Role of a user by bench, and under ``*`` at all."""
        found: dict[str, Role] = {}
        for grant in user.grants:
            for bench in self._at(grant.where):
                found[bench] = max(grant.role, found.get(bench, grant.role))
        return found

    def role_at(self, user: SiteMember, bench: str) -> Role | None:
        """Role of a user at a bench; None: it has none there. Benches are operators to each other."""
        if user.is_bench:
            return Role.OPERATOR
        levels = self.levels(user)
        return max((levels[each] for each in (EVERYWHERE, bench) if each in levels), default=None)

    def _at(self, where: str) -> list[str]:
        if "=" not in where:
            return [where]
        key, _, value = where.partition("=")
        return [bench.name for bench in self.benches if bench.labels.get(key) == value]

    def certified_name(self, name: str) -> str:
        """Name that a member's next certificate has: its own, or ``otto+2`` where that was revoked."""
        spent = self.spent.get(name, 0)
        return f"{name}+{spent + 1}" if spent else name

    def with_member(self, member: SiteMember) -> "SiteList":
        """Copy with a member, which takes the place of one of its name."""
        return replace(self, members={**self.members, member.name: member})

    def without(self, name: str, serials: Sequence[str]) -> "SiteList":
        """Copy without a member, whose certificates are revoked, and whose certified name is spent."""
        members = {key: each for key, each in self.members.items() if key != name}
        return replace(
            self,
            members=members,
            revoked=self.revoked | set(serials),
            spent={**self.spent, name: self.spent.get(name, 0) + 1},
        )


def read_grant(text: str) -> RoleGrant:
    """Read a role and where it holds, as ``operator``, ``operator@mill`` or ``viewer@rig=press``.

    Raises:
        SecurityError: it is none.
    """
    role, at, where = text.partition("@")
    if role not in _ROLES:
        raise SecurityError(
            f"role {text!r}: there is no role {role!r}; write {', '.join(_ROLES)}, and behind @"
            " where it holds"
        )
    if not at or where == EVERYWHERE:
        return RoleGrant(_ROLES[role])
    if "=" in where:
        read_label(where)
    elif not BENCH_NAME.fullmatch(where):
        raise SecurityError(
            f"role {text!r}: behind @ stands a bench's name or a label, as in {role}@rig=press"
        )
    return RoleGrant(_ROLES[role], where)


def read_label(text: str) -> tuple[str, str]:
    """Read a label, as ``rig=press``.

    Raises:
        SecurityError: it is none.
    """
    name, _, value = text.partition("=")
    if not (_LABEL_NAME.fullmatch(name) and is_label_value(value)):
        raise SecurityError(
            f"label {text!r}: write KEY=VALUE, as in rig=press; a key is a letter a-z and up to 31"
            " of a-z, 0-9,"
            f" _ and -, a value letters, digits and . _ / : -, at most {LABEL_CHARACTERS} of them"
        )
    return name, value


def check_name(name: str, is_bench: bool) -> None:
    """Refuse a name that no member can have. Raises SecurityError."""
    if name.lower() == ROUTER:
        raise SecurityError(f"{name!r} is the name of the router's certificate; take another")
    if is_bench and not BENCH_NAME.fullmatch(name):
        raise SecurityError(f"{name!r}: a bench's name is a letter a-z and up to 31 of a-z, 0-9, _, -")
    if not USER_NAME.fullmatch(name):
        raise SecurityError(f"{name!r} is no name: letters, digits, _ . - and at most 64 of them")


def written(of: SiteList) -> bytes:
    """Text of a list, which is signed as it is."""
    content = {
        "v": LIST_VERSION,
        "site": of.site,
        "number": of.number,
        "routers": list(of.routers),
        "benches": {
            each.name: {"certified": each.certified, "labels": dict(each.labels)} for each in of.benches
        },
        "users": {
            each.name: {"certified": each.certified, "roles": [str(grant) for grant in each.grants]}
            for each in of.users
        },
        "revoked": sorted(of.revoked),
        "spent": dict(of.spent),
    }
    return json.dumps(content, indent=1, ensure_ascii=True).encode() + b"\n"


def parsed(text: bytes, where: str) -> SiteList:
    """Parse a list whose signature is good. ``where`` stands before problems.

    Raises:
        SecurityError: another version of this program wrote it, or it is no list.
    """
    try:
        content = read_json(text)
        if content.get("v") != LIST_VERSION:
            raise SecurityError(
                f"{where}: it is a list of version {content.get('v')}, and this hil reads {LIST_VERSION};"
                " use the same version of hil at all computers of the site"
            )
        return _site_list(content)
    except (JsonError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise SecurityError(f"{where}: it is no list of a site ({error}); copy it again") from None


def _site_list(content: Any) -> SiteList:
    benches = {
        name: SiteMember(name, _text(each["certified"]), True, dict(map(read_label, _pairs(each["labels"]))))
        for name, each in content["benches"].items()
    }
    users = {
        name: SiteMember(
            name, _text(each["certified"]), grants=[read_grant(_text(one)) for one in each["roles"]]
        )
        for name, each in content["users"].items()
    }
    members = {**benches, **users}
    if len(members) < len(benches) + len(users):
        raise ValueError("a bench and a user have the same name")
    certified = [each.certified for each in members.values()]
    if len(set(certified)) < len(certified):
        raise ValueError("two members have the same name in their certificates")
    for member in members.values():
        check_name(member.name, member.is_bench)
    number, spent = content["number"], content["spent"]
    if type(number) is not int or number < 1 or not all(type(each) is int for each in spent.values()):
        raise ValueError("number and spent are whole numbers from 1")
    if not all(_SERIAL.fullmatch(_text(each)) for each in content["revoked"]):
        raise ValueError("revoked has serial numbers as hexadecimal")
    if not all(_DOOR.fullmatch(_text(each)) for each in content["routers"]):
        raise ValueError("routers has endpoints, as tls/hub.lan:7447")
    return SiteList(
        _text(content["site"]), number, content["routers"], members, frozenset(content["revoked"]), spent
    )


def _pairs(labels: Mapping[str, Any]) -> list[str]:
    return [f"{key}={value}" for key, value in labels.items()]


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value
