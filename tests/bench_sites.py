"""Benches that a router joins, each on a computer of its own (a network namespace, where they can be made) or
side by side."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, config, free_port, until

SAC = {"profile": "sac", "flash": {}}
PORT = 7447


def ip(*arguments: str) -> None:
    subprocess.run(("ip", *arguments), check=True, capture_output=True, text=True, timeout=PATIENCE_S)


@dataclass
class Site:
    """Place where benches and router run: prefixes of their commands, and the address under which each bench
    reaches the router."""

    place: Place
    addresses: dict[str, str]
    prefixes: dict[str, tuple[str, ...]] = field(default_factory=dict)
    router: subprocess.Popen[bytes] | None = None

    def join(self) -> None:
        """Start the router."""
        listen = [
            option for address in sorted(set(self.addresses.values())) for option in ("--listen", address)
        ]
        command = [*self.prefixes.get("router", ()), HIL, "zenoh", "router", *listen, "--insecure"]
        self.router = subprocess.Popen(command, stdout=subprocess.PIPE)
        assert self.router.stdout is not None
        assert b"Ctrl-C ends it" in self.router.stdout.readline()

    def part(self) -> None:
        """Kill the router."""
        if self.router:
            self.router.kill()
            self.router.communicate(timeout=PATIENCE_S)

    def launch(self, bench: str, speed: float = 1, **zenoh: Any) -> Server:
        """Start a bench."""
        bridge = {"listen": [], "connect": [self.addresses[bench]], **zenoh}
        text = config(bench, speed, {"m1": {}, "s1": SAC}, bridges={"zenoh": bridge})
        return self.place.launch(text, bench=bench, prefix=self.prefixes.get(bench, ()))

    def serve(self, bench: str, speed: float = 1, **zenoh: Any) -> Server:
        """Start a bench, and enable its servo."""
        return enabled(self.launch(bench, speed, **zenoh))

    def two(self, speed: float = 1) -> tuple[Server, Server]:
        """Start two benches, until they see each other."""
        mill, lathe = map(enabled, [self.launch("mill", speed), self.launch("lathe", speed)])
        for server, other in ((mill, "lathe"), (lathe, "mill")):
            until(lambda s=server, o=other: sees(s, o), f"a sight of {other}")  # type: ignore[misc]
        return mill, lathe


def enabled(server: Server) -> Server:
    server.started().ready().ask("do", device="m1", name="enable", parameters={})
    return server


def sees(server: Server, other: str) -> bool:
    return other in [row["bench"] for row in server.ask("benches")]


@contextmanager
def side_by_side(place: Place) -> Iterator[Site]:
    """Site whose benches and router are side by side."""
    door = f"tcp/127.0.0.1:{free_port()}"
    made = Site(place, {"mill": door, "lathe": door, "third": door})
    made.join()
    yield made
    made.part()


@contextmanager
def on_hosts(place: Place) -> Iterator[Site]:
    """Site whose router and benches are each on a computer of its own."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and iproute2")
    tag = str(os.getpid())
    names = {name: f"hil{tag}{name}" for name in ("router", "mill", "lathe")}
    with ExitStack() as stack:
        try:
            for name in names.values():
                ip("netns", "add", name)
                stack.callback(ip, "netns", "del", name)
        except subprocess.CalledProcessError as error:
            pytest.skip(f"no network namespaces here: {error.stderr.strip()}")
        for number, bench in enumerate(("mill", "lathe"), 1):
            ends = f"r{bench}", "eth0"
            near, far = names["router"], names[bench]
            ip("link", "add", ends[0], "netns", near, "type", "veth", "peer", ends[1], "netns", far)
            for host, end, last in (("router", ends[0], 1), (bench, ends[1], 2)):
                ip("-n", names[host], "addr", "add", f"10.214.{number}.{last}/24", "dev", end)
                for link in ("lo", end):
                    ip("-n", names[host], "link", "set", link, "up")
        addresses = {"mill": f"tcp/10.214.1.1:{PORT}", "lathe": f"tcp/10.214.2.1:{PORT}"}
        made = Site(place, addresses, {host: ("ip", "netns", "exec", name) for host, name in names.items()})
        made.join()
        yield made
        made.part()


def run(name: str, *steps: dict[str, Any], **top: Any) -> str:
    rules = {"velocity_rpm": 120.0, "acceleration_rpm_per_s": 3000.0, "jerk_rpm_per_s2": 1e5}
    axes = {"m1": rules, "lathe/m1": rules, "s1": {}, "lathe/s1": {}}
    return json.dumps({"run": name, "axes": axes, "steps": list(steps)} | top)


FAR = {"move": {"m1": 7200.0, "lathe/m1": 7200.0}}


def submit(server: Server, text: str, *, fresh: bool = False) -> dict[str, Any]:
    answer: dict[str, Any] = server.ask("run", text=text, file="r", check=False, fresh=fresh)
    return answer


def on_the_way(server: Server) -> None:
    until(lambda: server.status("m1")["snapshot"]["r"] > 60, "some way")


def state_of(server: Server, name: str) -> str:
    return next((row["state"] for row in server.ask("runs", name="") if row["run"] == name), "")
