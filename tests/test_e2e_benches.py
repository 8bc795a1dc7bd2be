"""Runs over two benches that a router joins."""

import json
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from bench_sites import (
    FAR,
    Site,
    on_the_way,
    run,
    state_of,
    submit,
)
from e2e_support import HIL, PATIENCE_S, Server, ended, until
from markdown_blocks import fits
from page_sessions import steps as steps_of

PAGE = "docs/how-to/runs.md"
VARIES = (r"-?\d+\.\d+", "ahead|behind", "earlier|later")


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
    told_ns = abs(clock["began_apart_ns"])
    assert told_ns < 2_000_000 + clock["clock_error_ns"], told_ns


@pytest.mark.thorough
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
    assert submit(mill, run("r", *steps), fresh=True)["run"] == "r-2"  # again, on both
    assert [ended(bench, "r-2")["state"] for bench in (mill, lathe)] == ["done", "done"]
    benches, both, cut = (step for step in steps_of(PAGE) if "-b mill" in step.command)
    for step in (benches, both):
        said = site.place.cli(*step.command.split()[1:], "--runtime-dir", str(site.place.runtime))
        assert fits(step.shown, said, *VARIES), said
    axes = {"mill/m1": {}, "lathe/m1": {}}
    way = {"move": dict.fromkeys(axes, 72_000.0)}
    site.place.write(json.dumps({"run": "cut", "axes": axes, "steps": [way]}), "cut.yaml")
    command = [HIL, *cut.command.split()[1:], "--runtime-dir", str(site.place.runtime)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=site.place.folder) as running:
        on_the_way(mill)
        lathe.kill()
        said, _ = running.communicate(timeout=PATIENCE_S)
    assert (running.returncode, fits(cut.shown, said, *VARIES)) == (3, True), said


@pytest.mark.thorough
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


@pytest.mark.thorough
def test_cancelled_while_it_begins(site: Site) -> None:
    mill, lathe = site.two()
    for n in range(10):
        submit(mill, run(f"r{n}", FAR))
        mill.ask("cancel_run", name=f"r{n}", how="grace")
        assert ended(mill, f"r{n}")["state"] == "cancelled"
    until(lambda: all(row["state"] == "cancelled" for row in lathe.ask("runs", name="")), "the other's end")
    submit(mill, run("then", {"move": {"m1": 5.0, "lathe/m1": 5.0}}))
    assert ended(mill, "then")["state"] == "done"


@pytest.mark.thorough
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


@pytest.mark.thorough
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
    assert "third: hil " in site.place.cli("list", "--joined", "-b", "mill", *where)
    fast.stop()

    submit(lathe, json.dumps({"run": "mine", "axes": {"m1": {}}, "steps": [{"move": {"m1": 720.0}}]}))
    assert "axes.'lathe/m1': it is in the run mine" in submit(mill, run("r", FAR))["problems"]
    lathe.ask("cancel_run", name="mine", how="prejudice")
    ended(lathe, "mine")
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
    assert submit(mill, own)["state"] == "failed"  # it is that run
    submit(mill, own, fresh=True)
    assert ended(mill, "own-2")["state"] == "done"
    lathe.ask("do", device="m1", name="disable", parameters={})
    assert "axes.'lathe/m1': its control loop is off" in submit(mill, run("s", FAR))["problems"]


@pytest.mark.thorough
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


@pytest.mark.thorough
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
    assert time.monotonic() - began_s < 5  # with grace alone it takes six
