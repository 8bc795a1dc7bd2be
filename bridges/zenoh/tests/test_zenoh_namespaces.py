"""Attackers on another computer: passwords, and a daemon with no options at all."""

import secrets
from collections.abc import Iterator
from typing import Any

import pytest
from zenoh_attacks import (
    ATTACKER,
    COMMANDS,
    DAEMON,
    DEADLINE_S,
    FAULTS,
    LIVE,
    NEVER,
    READ,
    TOLD,
    UNTOLD,
    USERS,
    ours,
)
from zenoh_computers import (
    Lan,
    assert_refused,
    assert_rights,
    assert_untouched,
    child,
    lan,
    two_computers,
)

from bridges.zenoh.zenoh_config import client_config

pytestmark = pytest.mark.long


@pytest.fixture
def fresh_computers() -> Iterator[tuple[str, str]]:
    """Names of two computers that nobody else runs on."""
    with two_computers("b") as names:
        yield names


PASSWORDS = {name: secrets.token_urlsafe(24) for name in USERS}


@pytest.fixture(scope="module")
def by_password(computers: tuple[str, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lan]:
    path = tmp_path_factory.mktemp("users") / "users"
    path.touch(0o600)
    path.write_text(
        "".join(f"{name}:{role.name.lower()}:{PASSWORDS[name]}\n" for name, role in USERS.items())
    )
    endpoint = f"tcp/{DAEMON}:7447"
    with lan(computers, {"listen": [endpoint], "users": str(path)}, endpoint) as lan_now:
        yield lan_now


@pytest.mark.parametrize("user", USERS)
def test_a_password_gives_the_rights_of_its_role(by_password: Lan, user: str) -> None:
    config = client_config([by_password.endpoint], user, PASSWORDS[user])
    assert_rights(USERS[user], user, *by_password.tried(config, user, PASSWORDS[user]))


@pytest.mark.parametrize(
    ("user", "secret"),
    [
        (None, None),
        ("opa", "a-wrong-password"),
        ("opa", "the-viewers"),
        ("eve", "a-wrong-password"),
        ("", ""),
    ],
    ids=["stranger", "wrong-password", "another's", "unknown", "empty"],
)
def test_without_a_password_nobody_comes_in(by_password: Lan, user: str | None, secret: str | None) -> None:
    secret = PASSWORDS["vic"] if secret == "the-viewers" else secret
    assert_refused(by_password.tried(client_config([by_password.endpoint], user, secret), user, secret))


@pytest.mark.parametrize("mode", ["peer", "router"])
def test_without_a_password_no_peer_and_no_router_either(by_password: Lan, mode: str) -> None:
    config = {
        "mode": mode,
        "connect/endpoints": [by_password.endpoint],
        "listen/endpoints": [f"tcp/{ATTACKER}:7450"],
    }
    limits = {"connect/timeout_ms": 2000, "connect/exit_on_failure": True}
    assert_refused(by_password.tried(config | limits))


@pytest.mark.parametrize("mode", ["peer", "router"])
def test_a_viewer_that_says_it_is_a_peer_or_router_may_no_more(by_password: Lan, mode: str) -> None:
    config = client_config([by_password.endpoint], "vic", PASSWORDS["vic"]) | {
        "mode": mode,
        "listen/endpoints": [f"tcp/{ATTACKER}:7450"],
    }
    result, report = by_password.tried(config, "vic", PASSWORDS["vic"])
    assert [each for each in report["heard"] if each[0] != "query" or each[1] in (*FAULTS, COMMANDS[0])] == []
    assert set(result["narrow"]) <= set(TOLD)
    assert (result["wide"], result["admin"]) == ([], [])
    assert report["answers"] == ["genuine"]
    assert report["alive"] == [ours(LIVE)]


def test_a_peer_of_the_lan_with_zenohs_own_configuration_finds_nobody(by_password: Lan) -> None:
    result, report = by_password.tried({"mode": "peer"})
    assert (result["opened"], result["links"]) == (True, 0)
    for what in ("answered", "commanded", "narrow", "wide", "alive", "asked_alive", "admin"):
        assert result[what] == [], what
    assert report["heard"] == []
    assert_untouched(report)


def test_what_these_attacks_do_to_a_daemon_that_is_open(computers: tuple[str, str]) -> None:
    """With ``insecure: true`` all of them succeed: otherwise nothing above would say anything."""
    endpoint = f"tcp/{DAEMON}:7450"
    with lan(computers, {"listen": [endpoint], "insecure": True}, endpoint) as lan_now:
        result, report = lan_now.tried(client_config([endpoint]))
    assert result["answered"] == [*READ, "**", "other", "querier"]
    assert result["commanded"] == [*COMMANDS, *FAULTS]
    assert set(result["narrow"]) == {*TOLD, UNTOLD}
    assert set(result["wide"]) == {ours(key) for key in (*TOLD, UNTOLD, LIVE) if key != "sim/clock"}
    heard = {(what, key) for what, key, _ in report["heard"]}
    for key in (*COMMANDS, *FAULTS, *NEVER):
        assert {("put", key), ("delete", key)} <= heard
    assert set(report["alive"]) == {ours(LIVE), ours("@live/axis/forged")}
    assert set(report["answers"]) == {"genuine", "forged"}


def multicast_of(computers: tuple[str, str], what: str, given: Any, for_s: float) -> tuple[int, list[str]]:
    """Frames to groups that reach the other computer from the start of a session on, and its sockets."""
    with child(computers[1], "count", for_s) as counting:
        assert counting.read() == {"ready": True}
        with child(computers[0], what, given) as session:
            assert session.read() == {"ready": True}
            open_sockets = session.ask()["sockets"] if what == "serve" else []
            return counting.ask(for_s + DEADLINE_S)["count"], open_sockets


def test_by_default_a_daemon_is_heard_on_its_own_computer_only(fresh_computers: tuple[str, str]) -> None:
    count, open_sockets = multicast_of(fresh_computers, "serve", {}, 3.0)
    assert (count, open_sockets) == (0, ["tcp 0100007F:1D17"]), "127.0.0.1:7447 and nothing else"


def test_zenohs_own_configuration_would_be_noticed(fresh_computers: tuple[str, str]) -> None:
    assert multicast_of(fresh_computers, "open", None, 3.0)[0] > 0
