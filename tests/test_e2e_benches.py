"""Runs over two benches that a router joins, each on a computer of its own (a network namespace, where they
can be made) or side by side."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, config, until
from test_e2e_runs import ended, free_port

from hil.client import CommandError, connect_sync

SAC = {"profile": "sac", "flash": {}}
PORT = 7447


def ip(*arguments: str) -> None:
    subprocess.run(("ip", *arguments), check=True, capture_output=True, text=True, timeout=PATIENCE_S)


@dataclass
class Site:
    """Where benches and router run: prefixes of their commands, and under which address each reaches the
    router."""

    place: Place
    addresses: dict[str, str]
    prefixes: dict[str, tuple[str, ...]] = field(default_factory=dict)
    router: subprocess.Popen[bytes] | None = None

    def join(self) -> None:
        """The router starts."""
        listen = [
            option for address in sorted(set(self.addresses.values())) for option in ("--listen", address)
        ]
        command = [*self.prefixes.get("router", ()), HIL, "zenoh", "router", *listen, "--insecure"]
        self.router = subprocess.Popen(command, stdout=subprocess.PIPE)
        assert self.router.stdout is not None
        assert b"Ctrl-C ends it" in self.router.stdout.readline()

    def part(self) -> None:
        """It is gone at once."""
        if self.router:
            self.router.kill()
            self.router.communicate(timeout=PATIENCE_S)

    def launch(self, bench: str, speed: float = 1, **zenoh: Any) -> Server:
        """A bench starts."""
        bridge = {"listen": [], "connect": [self.addresses[bench]], **zenoh}
        text = config(bench, speed, {"m1": {}, "s1": SAC}, bridges={"zenoh": bridge})
        return self.place.launch(text, bench=bench, prefix=self.prefixes.get(bench, ()))

    def serve(self, bench: str, speed: float = 1, **zenoh: Any) -> Server:
        """A bench, whose servo is enabled."""
        return enabled(self.launch(bench, speed, **zenoh))

    def two(self, speed: float = 1) -> tuple[Server, Server]:
        """Two benches that see each other."""
        mill, lathe = map(enabled, [self.launch("mill", speed), self.launch("lathe", speed)])
        for server, other in ((mill, "lathe"), (lathe, "mill")):
            until(lambda s=server, o=other: sees(s, o), f"a sight of {other}")  # type: ignore[misc]
        return mill, lathe


def enabled(server: Server) -> Server:
    server.started().ready().ask("do", device="m1", name="enable", parameters={})
    return server


def sees(server: Server, other: str) -> bool:
    return other in [row["bench"] for row in server.ask("benches")]


@pytest.fixture
def site(place: Place) -> Iterator[Site]:
    """Side by side."""
    door = f"tcp/127.0.0.1:{free_port()}"
    made = Site(place, {"mill": door, "lathe": door, "third": door})
    made.join()
    yield made
    made.part()


@pytest.fixture
def hosts(place: Place) -> Iterator[Site]:
    """The router and each bench on a computer of its own."""
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


def submit(server: Server, text: str) -> dict[str, Any]:
    answer: dict[str, Any] = server.ask("run", text=text, file="r", check=False)
    return answer


def on_the_way(server: Server) -> None:
    until(lambda: server.status("m1")["snapshot"]["r"] > 60, "some way")


def epoch_ns(server: Server) -> tuple[int, int]:
    """This computer's time at simulated time 0 of a bench, and how far it may be off; by its own answers."""
    best = (1 << 62, 0)
    for _ in range(100):
        asked_ns = time.time_ns()
        sim_ns = server.ask("status")["sim_ns"]
        heard_ns = time.time_ns()
        best = min(best, (heard_ns - asked_ns, (asked_ns + heard_ns) // 2 - sim_ns))
    return best[1], best[0] // 2


def test_a_run_over_two_hosts_begins_at_one_time(hosts: Site) -> None:
    mill, lathe = hosts.two()
    watches = [
        (server, server.ask("watch", device="m1", signals=["r"], interval_ns=100_000))
        for server in (mill, lathe)
    ]
    submit(
        mill, run("both", {"move": {"m1": 90.0, "lathe/m1": -45.0}}, {"line": {"m1": 0.0, "lathe/m1": 90.0}})
    )
    begins = []
    for server, watch in watches:
        rows: list[list[float]] = []

        def moved(rows: list[list[float]] = rows, server: Server = server, watch: Any = watch) -> bool:
            rows += server.ask("samples", watch=watch["watch"])["rows"]
            return any(row[1] != rows[0][1] for row in rows)

        until(moved, "the first motion")
        first_ns = next(row[0] for row in rows if row[1] != rows[0][1])
        zero_ns, error_ns = epoch_ns(server)
        begins.append((zero_ns + first_ns, error_ns))
    progress = ended(mill, "both")
    assert progress["state"] == "done", progress
    assert abs(progress["axes"]["lathe/m1"]["position_deg"] - 90) < 0.5
    assert {axis["at_end"] for axis in progress["axes"].values()} == {"stands"}
    assert ended(lathe, "both")["state"] == "done"
    apart_ns = abs(begins[0][0] - begins[1][0])
    print(f"begun {apart_ns / 1e6:.3f} ms apart, known to {(begins[0][1] + begins[1][1]) / 1e6:.3f} ms")
    assert apart_ns < 2_000_000 + begins[0][1] + begins[1][1]
    clock = progress["benches"]["lathe"]
    # Both computers are this one: what is measured between their clocks is what the measurement is off by.
    assert abs(clock["clock_offset_ns"]) < clock["clock_error_ns"] + 1_000_000
    assert 0 < clock["clock_error_ns"] < 100_000_000


def test_a_host_whose_wire_is_cut_is_told_of_and_both_sides_stop(hosts: Site) -> None:
    mill, lathe = hosts.two()
    wire = ("-n", hosts.prefixes["router"][-1], "link", "set", "rlathe")
    submit(mill, run("cut", FAR, on_fault="prejudice"))
    on_the_way(mill)
    ip(*wire, "down")
    cut_s = time.monotonic()
    progress = ended(mill, "cut")
    told_s = time.monotonic() - cut_s
    print(f"told of after {told_s:.2f} s")
    assert told_s < 4  # 1.0 s of silence, at most 0.4 s more, and what else this machine does
    assert progress["state"] == "failed"
    assert progress["why"].startswith("the bench lathe is gone: silent for 1.")
    assert progress["axes"]["lathe/m1"]["at_end"] == "unknown"
    assert progress["axes"]["m1"]["at_end"] == "stands"
    there = ended(lathe, "cut")
    assert there["state"] == "failed"
    assert there["why"].startswith("the bench mill, which leads, is gone")
    assert there["axes"]["lathe/m1"]["at_end"] == "stands"
    assert 60 < there["axes"]["lathe/m1"]["position_deg"] < 7200
    ip(*wire, "up")
    again = run("again", {"move": {"m1": 0.0, "lathe/m1": 0.0}, "in_s": 3.0}, start_in_s=0.2)
    until(lambda: "problems" not in submit(mill, again), "the wire")


def test_a_router_that_goes_in_the_middle_stops_both_and_comes_back(site: Site) -> None:
    mill, lathe = site.two()
    submit(mill, run("r", FAR))
    on_the_way(lathe)
    site.part()
    for server, gone in ((mill, "the bench lathe is gone"), (lathe, "the bench mill, which leads, is gone")):
        progress = ended(server, "r")
        assert (progress["state"], progress["why"][: len(gone)]) == ("failed", gone)
    assert mill.status("m1")["snapshot"]["following"] == 0
    assert "lathe" in submit(mill, run("s", FAR))["problems"]
    site.join()
    near = {"move": {"m1": 7200.0, "lathe/m1": 0.0}, "in_s": 30.0}
    until(lambda: "problems" not in submit(mill, run("t", near)), "the router's return")
    until(lambda: state_of(lathe, "t") == "running", "its part")
    mill.ask("cancel_run", name="t", how="prejudice")
    assert ended(lathe, "t")["state"] == "cancelled"


def test_a_leader_that_is_killed_leaves_no_axis_moving(site: Site) -> None:
    mill, lathe = site.two()
    submit(mill, run("r", FAR))
    on_the_way(lathe)
    mill.process.send_signal(signal.SIGKILL)
    progress = ended(lathe, "r")
    assert progress["state"] == "failed"
    assert progress["axes"]["lathe/m1"]["at_end"] == "stands"


def test_phrases_waits_and_steppers_over_both(site: Site) -> None:
    mill, lathe = site.two(speed=5)
    steps = (
        {"label": "again", "move": {"m1": 30.0, "lathe/s1": 45.0}},
        {"wait_until": {"axis": "lathe/s1", "field": "position_deg", "above": 44.0}},
        {"pins": {"lathe/m1.D3": 1, "m1.D3": 1}},
        {"move": {"lathe/m1": 20.0, "s1": 9.0}},
        {"move": {"m1": 0.0, "lathe/m1": 0.0, "s1": 0.0, "lathe/s1": 0.0}},
        {"repeat": {"label": "again", "times": 1}},
    )
    submit(mill, run("r", *steps))
    progress = ended(mill, "r")
    assert (progress["state"], progress["step"]) == ("done", 10), progress["why"]
    assert [abs(axis["position_deg"]) < 0.5 for axis in progress["axes"].values()] == [True] * 4
    assert lathe.status("m1")["snapshot"]["pin_d3"] == 1
    assert submit(mill, run("r", *steps))["state"] in ("queued", "running")  # again, on both
    assert ended(mill, "r")["state"] == "done"


@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_cancelled_at_either_end(site: Site, how: str) -> None:
    mill, lathe = site.two()
    for name, server in (("a", mill), ("b", lathe)):
        submit(mill, run(name, FAR))
        for bench in (mill, lathe):  # the one that joins holds its axes before the one that leads begins
            until(lambda n=name, bench=bench: state_of(bench, n) == "running", "its beginning")
        server.ask("cancel_run", name=name, how=how)
        for bench in (mill, lathe):
            progress = ended(bench, name)
            assert progress["state"] == "cancelled", progress
            assert {axis["at_end"] for axis in progress["axes"].values()} == {"stands"}


def state_of(server: Server, name: str) -> str:
    return next((row["state"] for row in server.ask("runs", name="") if row["run"] == name), "")


def test_cancelled_while_it_begins(site: Site) -> None:
    mill, lathe = site.two()
    for n in range(10):
        submit(mill, run(f"r{n}", FAR))
        mill.ask("cancel_run", name=f"r{n}", how="grace")
        assert ended(mill, f"r{n}")["state"] == "cancelled"
    until(lambda: all(row["state"] == "cancelled" for row in lathe.ask("runs", name="")), "the other's end")
    submit(mill, run("then", {"move": {"m1": 5.0, "lathe/m1": 5.0}}))
    assert ended(mill, "then")["state"] == "done"


def test_an_axis_that_stalls_there_stops_all(site: Site) -> None:
    mill, lathe = site.two()
    rules = {"velocity_rpm": 60.0, "following_error_deg": 10.0}
    text = {"run": "r", "axes": {"m1": rules, "lathe/m1": rules}, "steps": [FAR]}
    submit(mill, json.dumps(text))
    on_the_way(lathe)
    lathe.ask("inject", fault="shaft_jam", target="m1", parameters={})
    progress = ended(mill, "r")
    assert progress["state"] == "failed"
    assert progress["why"].startswith("lathe: lathe/m1 is ")
    assert progress["axes"]["m1"]["position_deg"] < 7200


def test_what_cannot_be_is_listed_before_anything_moves(site: Site) -> None:
    mill, lathe = site.two(speed=2)
    fast = site.serve("third", speed=3)
    where = ("--runtime-dir", str(site.place.runtime))
    axes = "{m1: {}, mill/m1: {}, lathe/m9: {}, nowhere/m1: {}, third/m1: {}, third/s1: {}}"
    path = site.place.write(f"run: r\naxes: {axes}\nsteps:\n  - move: {{m1: 9}}\n", "r.yaml")
    assert "axes.'mill/m1': it is m1 once more" in site.place.cli(
        "run", str(path), "-b", "mill", *where, code=2
    )
    path.write_text(path.read_text().replace("mill/m1: {}, ", ""))
    said = site.place.cli("run", "--check", str(path), "-b", "mill", *where, code=2)
    assert "r.yaml:2:30: axes.'nowhere/m1': the bench nowhere did not answer" in said
    assert "axes.'third/m1': the time of bench third goes 3 times the wall's, here 2" in said
    path.write_text(path.read_text().replace("nowhere/m1: {}, third/m1: {}, third/s1: {}", ""))
    said = site.place.cli("run", str(path), "-b", "mill", *where, code=2)
    assert "r.yaml:2:16: axes.'lathe/m9': there is no device 'lathe/m9'" in said
    assert "third: hil " in site.place.cli("benches", "-b", "mill", *where)
    fast.stop()

    submit(lathe, json.dumps({"run": "own", "axes": {"m1": {}}, "steps": [{"move": {"m1": 720.0}}]}))
    assert "axes.'lathe/m1': it is in the run own" in submit(mill, run("r", FAR))["problems"]
    lathe.ask("cancel_run", name="own", how="prejudice")
    ended(lathe, "own")
    away = {"run": "own", "axes": {"s1": {}}, "steps": [{"move": {"s1": 36000.0}}]}
    submit(lathe, json.dumps(away))
    steps = [{"move": {"m1": 1.0, "lathe/m1": 1.0}}]
    own = json.dumps({"run": "own", "axes": {"m1": {}, "lathe/m1": {}}, "steps": steps})
    submit(mill, own)
    progress = ended(mill, "own")
    assert progress["state"] == "failed"
    assert "this bench has a run 'own' already" in progress["why"]
    lathe.ask("cancel_run", name="own", how="prejudice")
    ended(lathe, "own")
    submit(mill, own)
    assert ended(mill, "own")["state"] == "done", "one that has ended keeps its name from nobody"
    lathe.ask("do", device="m1", name="disable", parameters={})
    assert "axes.'lathe/m1': its control loop is off" in submit(mill, run("s", FAR))["problems"]


def test_users_are_asked_for_at_the_other_bench_too(site: Site) -> None:
    def users(name: str, *lines: str) -> str:
        path: Path = site.place.write("".join(f"{line}\n" for line in lines), name)
        path.chmod(0o600)
        return str(path)

    anna, mill_user = "anna:operator:annas-secret-word", "mill:operator:the-mills-secret"
    mill = site.serve("mill", users=users("a", anna, mill_user))
    lathe = site.serve("lathe", users=users("b", anna, mill_user))
    until(lambda: mill.ask("benches") and mill.ask("benches")[0]["why"] is None, "a sight of lathe")
    assert "no user 'lathe' to ask other benches as" in lathe.ask("benches")[0]["why"]
    submit(mill, run("r", {"move": {"m1": 5.0, "lathe/m1": 5.0}}))
    assert ended(mill, "r")["state"] == "done"
    lathe.stop()
    site.serve("lathe", users=users("b", anna, "mill:operator:another-secret"))
    until(lambda: "signature is wrong" in str(submit(mill, run("s", FAR)).get("problems")), "the refusal")


def test_a_bench_that_stood_still_does_not_move_on(site: Site) -> None:
    mill, lathe = site.two()
    submit(mill, run("r", FAR))
    on_the_way(lathe)
    lathe.process.send_signal(signal.SIGSTOP)
    assert ended(mill, "r")["why"].startswith("the bench lathe is gone")
    lathe.process.send_signal(signal.SIGCONT)
    progress = ended(lathe, "r")
    assert progress["state"] == "failed"
    assert "stood still" in progress["why"] or "is gone" in progress["why"]
    place_deg = progress["axes"]["lathe/m1"]["position_deg"]
    assert abs(lathe.status("m1")["snapshot"]["yw"] - place_deg) < 1


def test_what_is_no_part_of_a_run_does_no_harm(site: Site) -> None:
    mill, lathe = site.two()
    text = run("r", FAR)
    submit(mill, text)
    until(lambda: state_of(lathe, "r") == "running", "its part")
    with connect_sync("lathe", site.addresses["lathe"]) as client:
        far = {"do": "go", "token": "x", "phrase": 0, "start_wall_ns": 10**30}
        for given in (
            far,
            far | {"start_wall_ns": -1},
            {"do": "stop", "token": "x", "how": "grace", "state": "running", "why": ""},
            {"do": "join", "leader": "l", "token": "t", "document": text, "axes": {}, "digest": ""},
            {"do": "join", "leader": "l", "token": "t", "document": text, "axes": 1, "digest": 1},
            {"do": "go", "token": "x", "phrase": True, "start_wall_ns": 0},
            {"do": "nothing"},
            {},
        ):
            with pytest.raises(CommandError):
                client.link.ask("run/r/part", given)
        other = {"leader": "l", "token": "t", "document": run("other", FAR), "axes": {}, "digest": ""}
        with pytest.raises(CommandError, match="the document is of the run 'other'"):
            client.link.ask("run/w/part", {"do": "join"} | other)
    on_the_way(lathe)
    mill.ask("cancel_run", name="r", how="prejudice")
    assert ended(lathe, "r")["state"] == "cancelled"
    assert lathe.status("m1")["failed"] is None


def test_prejudice_after_grace_reaches_the_other_bench(site: Site) -> None:
    mill, lathe = site.two()
    slow = {"velocity_rpm": 60.0, "acceleration_rpm_per_s": 10.0}
    text = {"run": "r", "axes": {"m1": slow, "lathe/m1": slow}, "steps": [FAR]}
    submit(mill, json.dumps(text))
    on_the_way(lathe)
    mill.ask("cancel_run", name="r", how="grace")
    until(lambda: mill.ask("runs", name="r")[0]["why"], "the stop's beginning")
    assert state_of(mill, "r") == "running"  # it stops, with grace
    mill.ask("cancel_run", name="r", how="prejudice")
    began_s = time.monotonic()
    ended(mill, "r")
    assert ended(lathe, "r")["state"] == "cancelled"
    assert time.monotonic() - began_s < 3  # with grace alone it takes six


@pytest.mark.parametrize(("delay_s", "why"), [(0.06, "is known to"), (0.2, "did not answer")])
def test_a_network_that_is_too_slow_moves_nothing(site: Site, delay_s: float, why: str) -> None:
    near = site.addresses["mill"]
    with slow_proxy(near, delay_s) as far:
        site.addresses["lathe"] = far
        mill, lathe = enabled(site.launch("mill")), enabled(site.launch("lathe"))
        until(lambda: sees(mill, "lathe"), "a sight of lathe")
        before_deg = [server.status("m1")["snapshot"]["r"] for server in (mill, lathe)]
        tries = count()

        def refused() -> bool:
            name = f"r{next(tries)}"
            said = submit(mill, run(name, FAR)).get("problems") or ended(mill, name)["why"]
            assert why in said or "did not answer" in said, (
                said
            )  # on a busy machine the network is slower yet
            return why in said

        until(refused, f"an answer with {why!r}")
        assert [server.status("m1")["snapshot"]["r"] for server in (mill, lathe)] == before_deg


@contextmanager
def slow_proxy(address: str, delay_s: float) -> Iterator[str]:
    """An address behind which is another one, later."""
    target = ("127.0.0.1", int(address.rpartition(":")[2]))
    port = free_port()
    script = """
import asyncio, sys
port, target, delay_s = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
async def way(reader, writer):
    loop = asyncio.get_running_loop()
    while data := await reader.read(65536):
        loop.call_later(delay_s, writer.write, data)
    writer.close()
async def client(reader, writer):
    there = await asyncio.open_connection("127.0.0.1", target)
    await asyncio.gather(way(reader, there[1]), way(there[0], writer), return_exceptions=True)
async def main():
    async with await asyncio.start_server(client, "127.0.0.1", port) as server:
        print("here", flush=True)
        await server.serve_forever()
asyncio.run(main())
"""
    command = [sys.executable, "-c", script, str(port), str(target[1]), str(delay_s)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as proxy:
        assert proxy.stdout is not None
        assert proxy.stdout.readline() == b"here\n"
        try:
            yield f"tcp/127.0.0.1:{port}"
        finally:
            proxy.kill()
