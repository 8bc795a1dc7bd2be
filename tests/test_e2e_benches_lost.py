"""Runs over two benches that lose each other: cut wires, killed processes, slow and strange networks."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

import pytest
from bench_sites import (
    FAR,
    Site,
    enabled,
    ip,
    on_the_way,
    run,
    sees,
    state_of,
    submit,
)
from e2e_support import ended, free_port, until

from hil.client import CommandError, connect_sync


@pytest.mark.thorough
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
    assert told_s < 10  # 1.0 s of silence, at most 0.4 s more, and what else this machine does
    assert progress["state"] == "failed"
    assert re.match(r"the bench lathe is gone: silent for [1-9]\.", progress["why"])
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


@pytest.mark.thorough
def test_a_link_away_for_a_moment_does_not_end_a_run_that_can_bear_it(hosts: Site) -> None:
    mill, lathe = hosts.two()
    wire = ("-n", hosts.prefixes["router"][-1], "link", "set", "rlathe")
    submit(mill, run("bears", FAR, silence_s=30.0))
    on_the_way(lathe)
    for _ in range(2):
        ip(*wire, "down")
        time.sleep(0.9)
        ip(*wire, "up")
        time.sleep(1)
    states = [state_of(server, "bears") for server in (mill, lathe)]
    assert states == ["running", "running"], mill.ask("runs", name="bears")
    mill.ask("cancel_run", name="bears", how="prejudice")
    for server in (mill, lathe):
        assert ended(server, "bears")["state"] == "cancelled"


@pytest.mark.thorough
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


@pytest.mark.thorough
def test_a_leader_that_is_killed_leaves_no_axis_moving(site: Site) -> None:
    mill, lathe = site.two()
    submit(mill, run("r", FAR))
    on_the_way(lathe)
    mill.process.send_signal(signal.SIGKILL)
    progress = ended(lathe, "r")
    assert progress["state"] == "failed"
    assert progress["axes"]["lathe/m1"]["at_end"] == "stands"


@pytest.mark.thorough
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


@pytest.mark.thorough
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
        with pytest.raises(CommandError, match="lathe/m1 is in the run r"):  # the leader gives names
            client.link.ask("run/w/part", {"do": "join"} | other)
    on_the_way(lathe)
    mill.ask("cancel_run", name="r", how="prejudice")
    assert ended(lathe, "r")["state"] == "cancelled"
    assert lathe.status("m1")["failed"] is None


@pytest.mark.thorough
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
