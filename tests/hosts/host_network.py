"""Computers on a switch: network namespaces, joined by ``wire_switch.c``. Their links have delay, jitter and
loss, and can be cut while all runs.

The test itself is on a computer of its own, ``desk``: its process leaves the machine's network before it
opens anything, so that sessions of a client begin there. Needs root, iproute2 and a C compiler.
"""

import ctypes
import os
import select
import shutil
import signal
import subprocess
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

CLONE_NEWNET = 0x40000000
"""Flag of unshare(2): linux/sched.h."""
SOURCE = Path(__file__).with_name("wire_switch.c")
WARNINGS = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Werror")
PREFIX = "hilhost"
NAMESPACES = Path("/run/netns")
DEADLINE_S = 30.0
DESK = "desk"


class CannotBe(Exception):
    """Reason why there can be no such computers here."""


def run(*command: str | int | Path) -> str:
    """Run a program, and return what it wrote.

    Raises:
        CannotBe: it failed; the text is what it said.
    """
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    if done.returncode:
        raise CannotBe(f"{' '.join(words[:4])}: {done.stderr.strip()}")
    return done.stdout


def leave_the_machine() -> None:
    """Give this process a network of its own, in which only its loopback is.

    Raises:
        CannotBe: it is not root's, or something is missing.
    """
    if os.geteuid() != 0:
        raise CannotBe("computers on a switch are network namespaces, which need root")
    for program, package in (("ip", "iproute2"), ("cc", "gcc")):
        if not shutil.which(program):
            raise CannotBe(f"computers on a switch need {program}: apt install {package}")
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNET):
        raise CannotBe(f"no network namespaces here: {os.strerror(ctypes.get_errno())}")
    remove_left_behind()
    run("ip", "link", "set", "lo", "up")


def built(folder: Path) -> Path:
    """Compile the switch."""
    program = folder / "wire_switch"
    run("cc", *WARNINGS, "-o", program, SOURCE)
    return program


def remove_left_behind() -> None:
    """Remove the namespaces of test runs that were killed."""
    for each in NAMESPACES.glob(f"{PREFIX}*-*"):
        pid = each.name.removeprefix(PREFIX).partition("-")[0]
        if not Path("/proc", pid).exists():
            with suppress(CannotBe):
                run("ip", "netns", "del", each.name)


class Link:
    """Cable of a computer to the switch. Delays count each way: a question from one computer to another and
    its answer take four of them."""

    def __init__(self, switch: "Switch", port: int) -> None:
        self._switch, self._port = switch, port

    def set(self, *, delay_ms: float = 0, jitter_ms: float = 0, loss_percent: float = 0) -> None:
        """Change both directions. ``jitter_ms`` at most the delay."""
        for way in ("in", "out"):
            self.set_way(way, delay_ms=delay_ms, jitter_ms=jitter_ms, loss_percent=loss_percent)

    def set_way(
        self, way: str, *, delay_ms: float = 0, jitter_ms: float = 0, loss_percent: float = 0
    ) -> None:
        """Change the direction from the computer (``in``) or to it (``out``)."""
        us = f"{round(delay_ms * 1000)} {round(jitter_ms * 1000)}"
        self._switch.tell(f"{self._port} {way} {us} {round(loss_percent * 10_000)}")

    def cut(self) -> None:
        """Lose all that is sent from now on; what is under way arrives."""
        self.join(0)

    def join(self, network: int = 1) -> None:
        """Let it reach the computers of this network alone. All begin in network 1."""
        self._switch.tell(f"{self._port} network {network}")


class Computer:
    """Network namespace with an address."""

    def __init__(self, name: str, namespace: str, address: str, link: Link) -> None:
        self.name, self.namespace, self.address, self.link = name, namespace, address, link

    @property
    def prefix(self) -> tuple[str, ...]:
        """Words before a command that is to run there."""
        return () if self.name == DESK else ("ip", "netns", "exec", self.namespace)

    def endpoint(self, port: int = 7447, protocol: str = "tcp") -> str:
        return f"{protocol}/{self.address}:{port}"


class Switch:
    """Running ``wire_switch``. It ends with its input, also when this process is killed."""

    def __init__(self, prefix: Sequence[str], program: Path, ports: Sequence[str], seed: int) -> None:
        command = [*prefix, str(program), "ports", str(seed), *ports]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        assert self._line() == "ready"

    def tell(self, command: str) -> None:
        assert self.process.stdin
        self.process.stdin.write(command + "\n")
        assert self._line() == "ok", command

    def _line(self) -> str:
        assert self.process.stdout
        assert select.select([self.process.stdout], [], [], DEADLINE_S)[0], "the switch says nothing"
        return self.process.stdout.readline().strip()

    def close(self) -> None:
        self.process.kill()
        self.process.communicate(timeout=DEADLINE_S)


class HostNetwork:
    """Computers on one switch, made once. ``program``: the built switch."""

    def __init__(self, program: Path) -> None:
        self._program = program
        self._namespaces: list[str] = []
        self._switch: Switch | None = None
        self._started: list[subprocess.Popen[str]] = []

    def computers(self, *names: str, seed: int = 1) -> dict[str, Computer]:
        """Make computers of these names, and ``desk`` for the test. ``seed``: that of jitter and losses."""
        switch = self._namespace("switch")
        names = (DESK, *names)
        addresses = {name: f"10.77.0.{number}" for number, name in enumerate(names, 1)}
        for number, name in enumerate(names, 1):
            self._plug(switch, self._namespace(name) if name != DESK else None, number, addresses[name])
        inside = ("ip", "netns", "exec", switch)
        ports = [f"port{number}" for number in range(1, len(names) + 1)]
        self._switch = made = Switch(inside, self._program, ports, seed)
        return {
            name: Computer(name, self._full(name), addresses[name], Link(made, number))
            for number, name in enumerate(names, 1)
        }

    def start(self, computer: Computer, *command: str) -> subprocess.Popen[str]:
        """Start a program there; it is killed at the end, if it still runs."""
        words = [*computer.prefix, *command]
        started = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._started.append(started)
        return started

    def close(self) -> None:
        """Kill what runs on the computers, and remove them."""
        for process in self._started:
            process.kill()
            process.communicate(timeout=DEADLINE_S)
        if self._switch:
            self._switch.close()
        for name in self._namespaces:
            end_all_in(name)
            with suppress(CannotBe):
                run("ip", "netns", "del", name)
        with suppress(CannotBe):
            run("ip", "link", "del", "eth0")  # the desk's, if its other end is not gone yet

    def _plug(self, switch: str, namespace: str | None, number: int, address: str) -> None:
        """Put a cable between a computer and a port of the switch, which knows it by its hardware address."""
        here = ("ip", "-n", namespace) if namespace else ("ip",)
        there = ("netns", namespace) if namespace else ()
        inside = ("ip", "netns", "exec", namespace) if namespace else ()
        hardware = f"02:00:00:00:00:{number:02x}"
        port = f"port{number}"
        run("ip", "link", "add", "eth0", *there, "address", hardware, "type", "veth",
            "peer", "name", port, "netns", switch)  # fmt: skip
        run("ip", "-n", switch, "link", "set", port, "up")
        run(*here, "addr", "add", f"{address}/24", "dev", "eth0")
        for link in ("lo", "eth0"):
            run(*here, "link", "set", link, "up")
        run(*inside, self._program, "plain", "eth0")

    def _namespace(self, name: str) -> str:
        full = self._full(name)
        run("ip", "netns", "add", full)
        self._namespaces.append(full)
        return full

    def _full(self, name: str) -> str:
        return f"{PREFIX}{os.getpid()}-{name}"


def end_all_in(namespace: str) -> None:
    """Kill the processes of a namespace, and wait until they are gone."""
    give_up_s = time.monotonic() + DEADLINE_S
    while time.monotonic() < give_up_s:
        try:
            pids = [int(word) for word in run("ip", "netns", "pids", namespace).split()]
        except CannotBe:
            return
        if not pids:
            return
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        select.select([], [], [], 0.02)
