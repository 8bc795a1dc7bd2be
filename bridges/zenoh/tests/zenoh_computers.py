"""Two computers, as network namespaces with a wire between them: on one a daemon's session, on the other who
tries. Each is a process of its own. Needs root and iproute2.

The daemon's session is what the bridge opens, with stand-ins behind it that note what reaches them: on the
commands' keys with what the gate says to it.
"""

import json
import os
import selectors
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any

import pytest
import zenoh_attacks
from zenoh_attacks import (
    ATTACKER,
    COMMANDS,
    DAEMON,
    DEADLINE_S,
    FAULTS,
    LIVE,
    READ,
    TOLD,
    ours,
)

from hil.vocab.verbs import Role


def run(*command: str) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=DEADLINE_S)


@contextmanager
def two_computers(tag: str) -> Iterator[tuple[str, str]]:
    """The names of two namespaces, the daemon's and the attackers'."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and iproute2")
    here, there = f"hil{os.getpid()}{tag}0", f"hil{os.getpid()}{tag}1"
    wires = f"h{os.getpid()}{tag}0", f"h{os.getpid()}{tag}1"
    with ExitStack() as stack:
        try:
            for name in (here, there):
                run("ip", "netns", "add", name)
                stack.callback(run, "ip", "netns", "del", name)
            run(
                "ip", "link", "add", wires[0], "netns", here, "type", "veth", "peer", wires[1], "netns", there
            )
        except subprocess.CalledProcessError as error:
            pytest.skip(f"no network namespaces here: {error.stderr.strip()}")
        for name, wire, address in ((here, wires[0], DAEMON), (there, wires[1], ATTACKER)):
            run("ip", "-n", name, "addr", "add", f"{address}/24", "dev", wire)
            for link in ("lo", wire):
                run("ip", "-n", name, "link", "set", link, "up", "multicast", "on")
            run("ip", "-n", name, "route", "add", "224.0.0.0/4", "dev", wire)
        yield here, there


class Child:
    """``zenoh_attacks.py``, running in a namespace."""

    def __init__(self, namespace: str, what: str, given: Any) -> None:
        command = [
            "ip",
            "netns",
            "exec",
            namespace,
            sys.executable,
            zenoh_attacks.__file__,
            what,
            json.dumps(given),
        ]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )

    def read(self, deadline_s: float = DEADLINE_S) -> Any:
        assert self.process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self.process.stdout, selectors.EVENT_READ)
            assert selector.select(deadline_s), f"nothing within {deadline_s} s"
        line = self.process.stdout.readline()
        assert line, f"it ended with {self.process.wait(DEADLINE_S)}"
        return json.loads(line)

    def ask(self, deadline_s: float = DEADLINE_S) -> Any:
        assert self.process.stdin is not None
        self.process.stdin.write("report\n")
        return self.read(deadline_s)

    def end(self) -> None:
        try:
            self.process.communicate(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


@contextmanager
def child(namespace: str, what: str, given: Any) -> Iterator[Child]:
    running = Child(namespace, what, given)
    try:
        yield running
    finally:
        running.end()


class Lan:
    """A daemon that listens on the wire, and those who try."""

    def __init__(self, there: str, daemon: Child, endpoint: str) -> None:
        self.there, self.daemon, self.endpoint = there, daemon, endpoint

    def tried(
        self, config: Mapping[str, Any] | str, user: str | None = None, secret: str | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Result of an attacker, and the daemon's report after it."""
        with child(self.there, "attack", {"config": config, "user": user, "secret": secret}) as attacker:
            return attacker.read(), self.daemon.ask()


@contextmanager
def lan(computers: tuple[str, str], options: dict[str, Any], endpoint: str) -> Iterator[Lan]:
    with child(computers[0], "serve", options) as daemon:
        assert daemon.read() == {"ready": True}
        yield Lan(computers[1], daemon, endpoint)


def assert_rights(role: Role, user: str, result: dict[str, Any], report: dict[str, Any]) -> None:
    """Exactly what a role may, and nothing beside it."""
    commands = (*(COMMANDS if role >= Role.OPERATOR else ()), *(FAULTS if role >= Role.ADMIN else ()))
    assert result["opened"]
    assert result["answered"] == [*READ, "querier"]
    assert result["narrow"] == sorted(TOLD)
    assert result["wide"] == []
    assert result["alive"] == result["asked_alive"] == [ours(LIVE)]
    assert result["admin"] == []
    # A viewer's query with a payload at a parameter passes zenoh, which looks at no payload. The gate gives
    # the name, and the bridge refuses by the role.
    assert result["commanded"] == list(commands or COMMANDS[1:])

    heard = [tuple(each) for each in report["heard"]]
    expected = [("put", key, user) for key in commands]
    if role >= Role.OPERATOR:
        expected += [
            ("put", COMMANDS[0], "rejected: the command is not signed"),
            ("put", COMMANDS[0], user),
            ("put", COMMANDS[0], "rejected: the signature was used before"),
            ("put", "axis/m1/cmd/publisher", user),
        ]
    expected += [("query", key, "") for key in (*READ, "axis/m1/param/querier")]
    expected += [("query", key, user) for key in commands or COMMANDS[1:]]
    assert sorted(heard) == sorted(expected)
    assert_untouched(report)


def assert_untouched(report: dict[str, Any]) -> None:
    assert report["alive"] == [ours(LIVE)]
    assert report["answers"] == ["genuine"]
    assert report["peers"] == 0


def assert_refused(tried: tuple[dict[str, Any], dict[str, Any]]) -> None:
    result, report = tried
    assert result["opened"] is False, result
    assert report["heard"] == []
    assert_untouched(report)


def assert_let_in_for_nothing(tried: tuple[dict[str, Any], dict[str, Any]]) -> None:
    result, report = tried
    assert (result["opened"], result["links"]) == (True, 1)
    for what in ("answered", "commanded", "narrow", "wide", "alive", "asked_alive", "admin"):
        assert result[what] == [], what
    assert report["heard"] == []
    assert_untouched(report)
