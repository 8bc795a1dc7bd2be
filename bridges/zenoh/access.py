"""Zenoh's access control of a daemon or a router: who may send which messages on which keys, from the
table of keys. A user is known by password, by certificate, or by both."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from bridges.zenoh.keys import ABOUT, COMMAND, KEYS, PUBLISH, QUERY, expression, prefix
from bridges.zenoh.users import User
from hil.vocab.operation import HALT
from hil.vocab.verbs import Role

ALL = "*"
_Rule = tuple[str, list[str], list[str]]
"""Flow, messages and keys. Ingress is what the other end sends, egress what it is sent."""


_ABOUT_ALL = [expression(ALL, ABOUT)]
"""Question that each bench is asked with others: those who look do not know their names."""


@dataclass(frozen=True)
class Subject:
    """Somebody whom zenoh lets in. ``known_by``: zenoh's words for that. ``levels``: role by bench, or under
    ``*`` at all; ``bench``: name of the bench that it is, empty for a user."""

    name: str
    known_by: Mapping[str, Sequence[str]]
    levels: Mapping[str, Role]
    bench: str = ""


def _keys(benches: Iterable[str], way: str, *roles: Role) -> list[str]:
    return [
        expression(bench, key.pattern)
        for bench in benches
        for key in KEYS
        if way in key.way and (not roles or key.role in roles)
    ]


def _presence(bench: str) -> list[str]:
    return [f"{prefix(bench)}/@live/**", f"{prefix(bench)}/@one/*"]


def _rules_of_user(levels: Mapping[str, Role], scope: str) -> list[_Rule]:
    """Rules of a user. ``scope``: the one bench that is here, or ``*`` behind a router. There a question may
    go to all benches; what a role does not allow is not passed back. That a bench is there, all may see."""

    def at(role: Role) -> list[str]:
        if levels.get(ALL, 0) >= role:
            return [ALL]
        return [bench for bench, level in levels.items() if level >= role]

    seen, everything, live = at(Role.VIEWER), [f"{prefix(scope)}/**"], _presence(scope)
    rules: list[_Rule] = [
        ("ingress", ["declare_subscriber"], everything),
        ("egress", ["put"], _keys(seen, PUBLISH)),
        ("ingress", ["query"], [*_keys([scope], QUERY), *_ABOUT_ALL]),
        ("egress", ["reply"], _keys(seen, QUERY)),
        # A querier or publisher that is declared stays silent while it knows of nobody at the other end.
        ("egress", ["declare_queryable"], everything),
        ("ingress", ["liveliness_query", "declare_liveliness_subscriber"], live),
        ("egress", ["liveliness_token"], live),
    ]
    for role in (Role.OPERATOR, Role.ADMIN):
        if benches := at(role):
            rules += [
                ("ingress", ["put", "query"], _keys(benches, COMMAND, role)),
                ("egress", ["reply"], _keys(benches, COMMAND, role)),
            ]
    if at(Role.OPERATOR):
        # One message stops all benches; each decides whether the sender may.
        stop = [expression(ALL, HALT)]
        rules += [
            ("egress", ["declare_subscriber"], everything),
            ("ingress", ["put", "query"], stop),
            ("egress", ["reply"], stop),
        ]
    return [rule for rule in rules if rule[2]]


def _rules_of_bench(bench: str) -> list[_Rule]:
    """Rules of a bench at a router: it tells and answers under its own name alone, and asks others about runs
    over several benches, and to stop."""
    ours = [f"{prefix(bench)}/**"]
    parts = [expression(ALL, "run/<id>/part"), expression(ALL, HALT)]
    asked = [*_keys([bench], QUERY), *_keys([bench], COMMAND)]
    return [
        ("ingress", ["put"], _keys([bench], PUBLISH)),
        ("ingress", ["reply"], asked),
        ("ingress", ["declare_queryable", "declare_subscriber"], ours),
        ("ingress", ["liveliness_token"], _presence(bench)),
        ("ingress", ["query"], parts),
        ("ingress", ["liveliness_query", "declare_liveliness_subscriber"], _presence(ALL)),
        # What goes to several benches has * in its key; a bench gets what it has declared, and no other.
        ("egress", ["put"], _keys([ALL], COMMAND)),
        ("egress", ["query"], [*_keys([ALL], QUERY), *_keys([ALL], COMMAND)]),
        ("egress", ["reply"], parts),
        ("egress", ["declare_subscriber", "declare_queryable"], [f"{prefix(ALL)}/**"]),
        ("egress", ["liveliness_token"], _presence(ALL)),
    ]


def access_of(subjects: Sequence[Subject], scope: str) -> dict[str, Any]:
    """Make zenoh's ``access_control`` for the one bench ``scope``, or with ``*`` for a router. Others than
    the subjects may do nothing."""
    rules: list[_Rule] = []
    policies: list[dict[str, Any]] = []
    alike: dict[tuple[Any, ...], list[Subject]] = {}
    for each in subjects:
        alike.setdefault((each.bench, *sorted(each.levels.items())), []).append(each)
    for group in alike.values():
        bench, levels = group[0].bench, group[0].levels
        first = len(rules)
        rules += _rules_of_bench(bench) if bench else _rules_of_user(levels, scope)
        numbers = [f"{n}" for n in range(first, len(rules))]
        policies.append({"rules": numbers, "subjects": [each.name for each in group]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [
            {"id": f"{n}", "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": on}
            for n, (flow, messages, on) in enumerate(rules)
        ],
        "subjects": [{"id": each.name, **each.known_by} for each in subjects],
        "policies": policies,
    }


def access_control(
    users: Sequence[User], bench: str, by: Literal["usrpwd", "tls"] = "usrpwd"
) -> dict[str, Any]:
    """Make zenoh's ``access_control`` of a users' file for a daemon, or with the bench ``*`` for a router.

    With "tls" certificate and password both have to have the user's name.
    """
    benches = [user.name for user in users if user.is_bench and bench == ALL]

    def subject(user: User) -> Subject:
        is_bench = user.name in benches
        known_by = {"usernames": [user.name]}
        if by == "tls":
            own = [certified(each) for each in benches] if is_bench else [user.name]
            known_by["cert_common_names"] = own
        return Subject(user.name, known_by, {bench: user.role}, user.name if is_bench else "")

    return access_of([subject(user) for user in users], bench)


def certified(bench: str) -> str:
    """Name in the certificate of a bench's daemon. Benches of a users' file may share one certificate: it is
    the password that tells them apart."""
    return f"hil daemon {bench}"
