"""Multi-axis runs as their users submit them: from files, by the client, many at once."""

import json
import re
import threading
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from e2e_support import PATIENCE_S, Place, Server, config, ended, free_port, until

from hil.cli.framework.exit_codes import EXIT_CODES, Exit
from hil.client import ClientError, CommandError, connect_sync

SAC = {"profile": "sac", "flash": {}}
EXAMPLES = Path(__file__).parents[1] / "examples" / "runs"


def serve(place: Place, servos: int = 2, speed: float = 5, *options: str, **top: Any) -> tuple[Server, str]:
    """Serve a bench whose servos are enabled; the daemon, and where zenoh's door is."""
    port = free_port()
    devices: dict[str, Any] = {f"m{n}": {} for n in range(1, servos + 1)} | {"s1": SAC}
    bridges = {"zenoh": {"listen": [f"tcp/127.0.0.1:{port}"]}}
    server = place.serve(config(speed=speed, devices=devices, bridges=bridges, **top), *options).ready()
    for name in devices:
        if name != "s1":
            server.ask("do", device=name, name="enable", parameters={})
    return server, f"tcp/127.0.0.1:{port}"


def run(name: str, *steps: dict[str, Any], axes: tuple[str, ...] = ("m1",), **top: Any) -> str:
    rules = {"velocity_rpm": 240.0, "acceleration_rpm_per_s": 3000.0, "jerk_rpm_per_s2": 1e5}
    return json.dumps({"run": name, "axes": dict.fromkeys(axes, rules), "steps": list(steps)} | top)


def test_a_file_is_checked_carried_out_and_replayed(place: Place) -> None:
    log = place.folder / "log"
    server, _ = serve(place, 2, 5, "--log", str(log))
    where = ("--runtime-dir", str(place.runtime))
    said = place.cli("run", str(EXAMPLES / "square.yaml"), "--check", *where)
    assert "run square, 12 steps, no problems" in said
    said = place.cli("run", str(EXAMPLES / "square.yaml"), *where)
    assert "square: done\n  m1: stands at " in said
    assert said.count("following error at most") == 3
    bad = place.write("run: bad\naxes:\n  m9: {}\nsteps:\n  - {move: {m9: 1}}\n", "bad.run.yaml")
    said = place.cli("run", str(bad), *where, code=2)
    assert "bad.run.yaml:3:3: axes.m9: there is no device 'm9'" in said
    assert "No such file" in place.cli("run", "nowhere.yaml", *where, code=2)
    server.stop()
    assert "identical" in place.cli("replay", str(log))


def test_a_hundred_runs_at_once_are_all_done_in_their_order(place: Place) -> None:
    server, _ = serve(place, 2, 20)
    for n in range(100):
        axis = "m1" if n % 2 else "m2"
        answer = server.ask(
            "run", text=run(f"r{n}", {"move": {axis: n % 7}}, axes=(axis,)), file="x", check=False
        )
        assert answer["state"] in ("queued", "running"), answer
    done = [ended(server, f"r{n}") for n in range(100)]
    assert not [(progress["why"], progress["run"]) for progress in done if progress["state"] != "done"]
    for parity in (0, 1):
        ends = [progress["ended_at_ns"] for progress in done[parity::2]]
        assert ends == sorted(ends)


def test_the_same_name_is_the_same_run(place: Place) -> None:
    server, endpoint = serve(place)
    with connect_sync("t", endpoint) as client:
        first = client.submit(run("once", {"move_by": {"m1": 30.0}}))
        again = client.submit(run("once", {"move_by": {"m1": 30.0}}))
        assert first["run"] == again["run"] == "once"
        before = ended(server, "once")
        assert client.submit(run("once", {"move_by": {"m1": 30.0}}))["state"] == "done"
        assert client.run_state("once")["axes"] == before["axes"]


def test_a_file_is_carried_out_each_time_as_it_is_then(place: Place) -> None:
    server, endpoint = serve(place)
    where = ("--runtime-dir", str(place.runtime))
    planned_deg, names = [], []
    for by_deg in (30.0, 30.0, 10.0):
        file = place.write(run("again", {"move_by": {"m1": by_deg}}), "again.yaml")
        report = json.loads(place.cli("run", str(file), "--json", *where))
        planned_deg.append(report["axes"]["m1"]["target_deg"])
        names.append(report["run"])
    assert [b - a for a, b in pairwise(planned_deg)] == pytest.approx([30.0, 10.0], abs=1.0)
    assert names == ["again", "again-2", "again-3"]
    with connect_sync("t", endpoint) as client:  # over zenoh it may be a repetition that came late
        with pytest.raises(CommandError, match="another text, and is done: give this one another name"):
            client.submit(run("again", {"move": {"m1": 7200.0}}))
        assert client.submit(run("again", {"move_by": {"m1": 30.0}}))["submissions"] == 2
    assert [row["run"] for row in server.ask("runs", name="")] == names


def test_with_a_name_a_file_is_carried_out_at_most_once(place: Place) -> None:
    server, _ = serve(place)
    where = ("--name", "shift-7", "--runtime-dir", str(place.runtime))
    file = place.write(run("again", {"move_by": {"m1": 30.0}}), "again.yaml")
    first = place.cli("run", str(file), *where)
    assert "shift-7: done\n" in first
    again = place.cli("run", str(file), *where)
    assert again.startswith("shift-7: it was carried out before; this is how it does\nshift-7: done\n")
    changed = place.write(run("again", {"move_by": {"m1": 40.0}}), "changed.yaml")
    said = place.cli("run", str(changed), *where, code=1)
    assert said == "hil: the run shift-7 has another text, and is done: give this one another name\n"
    said = place.cli("run", str(file), "--name", "No Name", "--runtime-dir", str(place.runtime), code=2)
    assert "no name of a run: 'No Name'" in said
    assert [row["run"] for row in server.ask("runs", name="")] == ["shift-7"]


def test_runs_are_listed_shown_and_cancelled(place: Place) -> None:
    server, _ = serve(place, speed=1)
    where = ("--runtime-dir", str(place.runtime))
    assert place.cli("run", "list", *where) == "no run was submitted to this bench\n"
    far = place.write(run("far", {"move": {"m1": 72000.0}}), "far.yaml")
    assert place.cli("run", str(far), "--detach", *where).startswith("far: ")
    assert place.cli("run", str(far), "--detach", *where) == "far-2: queued\n"
    until(lambda: server.ask("runs", name="far")[0]["left_s"], "its plan")
    lines = place.cli("run", "list", *where).splitlines()
    assert re.fullmatch(r"far: running, step [01] of 1, \d+ s left", lines[0])
    assert lines[1:] == ["far-2: queued"]
    (row,) = json.loads(place.cli("run", "show", "far", "--json", *where))["axes"].values()
    assert row["target_deg"] == 72000
    assert "\n  m1: at " in place.cli("run", "show", "far", *where)
    status = place.cli("status")
    assert re.search(r"^run far: running, step [01] of 1, \d+ s left\s*\nrun far-2: queued\s*$", status, re.M)
    assert place.cli("run", "cancel", "far-2", *where).startswith("far-2: cancelled: ")
    place.cli("run", "cancel", "far", "--at-once", *where)
    assert ended(server, "far")["why"] == "it was cancelled with an immediate stop"
    said = place.cli("run", "cancel", "fa", *where, code=2)
    assert said.startswith("hil: there is no run 'fa'; did you mean \"far\"? there are far, far-2; `hil ")
    assert said.endswith(" run list` lists them\n")
    assert json.loads(place.cli("status", "--json"))["runs"] == []


def test_exit_codes_of_runs(place: Place) -> None:
    server, _ = serve(place, speed=5)
    where = ("--runtime-dir", str(place.runtime))
    far = str(place.write(run("far", {"move": {"m1": 72000.0}}), "far.yaml"))
    said: dict[str, str] = {}

    def carried_out(code: Exit, name: str) -> threading.Thread:
        def carry_out() -> None:
            said[name] = place.hil("run", far, "--name", name, *where, code=code)

        thread = threading.Thread(target=carry_out)
        thread.start()
        until(lambda: any(row["state"] == "running" for row in server.ask("runs", name="")), "the start")
        return thread

    thread = carried_out(Exit.RUN_CANCELLED, "a")
    server.ask("cancel_run", name="a", how="grace")
    thread.join()
    assert "a: cancelled: " in said["a"]
    thread = carried_out(Exit.RUN_FAILED, "b")
    server.ask("reset", device="m1")
    thread.join()
    assert "b: failed: " in said["b"]
    assert set(EXIT_CODES) == set(Exit)


def test_a_run_that_waited_keeps_its_count_and_its_place(place: Place) -> None:
    server, _ = serve(place, 2, 5)
    texts = {
        "b": run("b", {"dwell_s": 2.0}, {"move": {"m1": 1.0}}),
        "a": run("a", {"move": {"m1": 5.0}}),
        "c": run("c", {"move": {"m2": 5.0}}, axes=("m2",)),
    }
    for name in "baca":
        server.ask("run", text=texts[name], file="x", check=False)
    assert ended(server, "a")["submissions"] == 2
    assert [row["run"] for row in server.ask("runs", name="")] == ["b", "a", "c"]


def test_another_text_under_the_name_of_a_run_under_way_is_refused(place: Place) -> None:
    server, _ = serve(place)
    where = ("--runtime-dir", str(place.runtime))
    first = place.write(run("taken", {"move": {"m1": 36000.0}}), "first.yaml")
    other = place.write(run("taken", {"move": {"m1": 1.0}}), "other.yaml")
    place.cli("run", str(first), "--detach", *where)
    until(lambda: server.ask("runs", name="taken")[0]["state"] == "running", "the start")
    name = ("--name", "taken")
    said = place.cli("run", str(other), *name, *where, code=1)
    assert "the run taken has another text, and is running: give this one another name" in said
    assert "it is under way already" in place.cli("run", str(first), "--detach", *name, *where)
    server.ask("cancel_run", name="taken", how="prejudice")
    assert ended(server, "taken")["submissions"] == 2


def test_the_client_performs_and_hears_how_it_goes(place: Place) -> None:
    server, endpoint = serve(place)
    with connect_sync("t", endpoint) as client:
        told: list[bytes] = []
        with client.link.subscribe("run/*/state", told.append):
            until(lambda: client.submit(run("a", {"dwell_s": 0.1})) and told, "news of a run")
        axes = ("m1", "m2", "s1")
        done = client.perform(
            run("b", {"move": {"m1": 90.0, "s1": 45.0}}, {"line": {"m1": 0.0, "m2": 9.0}}, axes=axes)
        )
        assert done["state"] == "done"
        assert abs(done["axes"]["s1"]["position_deg"] - 45) < 0.5
        with pytest.raises(CommandError, match=r"steps\.0\.move\.m1: m1 may not go to") as refused:
            client.submit('{"run": "c", "axes": {"m1": {"max_deg": 5}}, "steps": [{"move": {"m1": 9}}]}')
        assert refused.value.code == "bad_run"
        for text in ("", "[", "x" * (900_000), "run: c\naxes: {m1: {}}\nsteps: [{move: {m1: .nan}}]"):
            with pytest.raises(CommandError):
                client.submit(text)
        with pytest.raises(ClientError, match="a message has at most 1000000"):
            client.submit(" " * 100_000_000)
    assert {row["run"] for row in server.ask("runs", name="")} == {"a", "b"}


@pytest.mark.thorough
@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_cancelled_on_the_way_and_while_it_waits(place: Place, how: Any) -> None:
    server, endpoint = serve(place, speed=1)
    with connect_sync("t", endpoint) as client:
        client.submit(run("long", {"move": {"m1": 7200.0}}))
        client.submit(run("next", {"move": {"m1": 0.0}}))
        until(lambda: client.run_state("long")["state"] == "running", "the start")
        assert client.run_state("next")["state"] == "queued"
        assert client.cancel("next", how)["state"] == "cancelled"
        until(lambda: client.axis("m1").state().r > 60, "some way")
        client.cancel("long", how)
        progress = ended(server, "long")
        assert progress["state"] == "cancelled"
        assert 60 < progress["axes"]["m1"]["position_deg"] < 7200
        assert client.axis("m1").state().following == 0
        with pytest.raises(CommandError, match="there is no run 'nix'"):
            client.cancel("nix")


def test_a_stalled_axis_stops_the_others_and_the_report_says_which(place: Place) -> None:
    server, _ = serve(place, speed=1)
    axes = {"m1": {"velocity_rpm": 60.0, "following_error_deg": 10.0}, "m2": {"velocity_rpm": 60.0}}
    text = json.dumps({"run": "r", "axes": axes, "steps": [{"move": {"m1": 3600.0, "m2": 3600.0}}]})
    server.ask("run", text=text, file="x", check=False)
    until(lambda: server.status("m1")["snapshot"]["r"] > 60, "some way")
    server.ask("inject", fault="shaft_jam", target="m1", parameters={})
    progress = ended(server, "r")
    assert progress["state"] == "failed"
    assert progress["why"].startswith("m1 is ")
    assert progress["axes"]["m2"]["position_deg"] < 3600


def test_many_submit_at_once(place: Place) -> None:
    server, endpoint = serve(place, speed=20)
    failures: list[str] = []

    def submit(first: int) -> None:
        with connect_sync("t", endpoint, timeout_s=PATIENCE_S) as client:
            for n in range(first, first + 25):
                try:
                    client.submit(run(f"r{n}", {"move": {"m1": n % 5}}))
                except CommandError as error:
                    failures.append(str(error))

    threads = [threading.Thread(target=submit, args=(25 * n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE_S * 2)
    assert failures == []
    assert {(end["state"], end["why"]) for end in (ended(server, f"r{n}") for n in range(100))} == {
        ("done", None)
    }


@pytest.mark.thorough
def test_long_documents_hold_nobody_up_and_leave_no_memory(place: Place) -> None:
    server, _ = serve(place, 2, 20)
    steps = [{"move": {"m1": n % 7}} for n in range(5000)]

    def rss_kB() -> int:
        rows = Path(f"/proc/{server.pid}/status").read_text().splitlines()
        return next(int(row.split()[1]) for row in rows if row.startswith("VmRSS"))

    answers: list[Any] = []

    def submit(name: str) -> None:
        answers.append(server.ask("run", text=run(name, *steps), file="x", check=False, timeout_s=PATIENCE_S))

    after: list[int] = []
    waits_s: list[float] = []
    for n in range(4):
        thread = threading.Thread(target=submit, args=(f"long{n}",))
        thread.start()
        longest_s = 0.0
        with server.client("m2") as terminal:
            while thread.is_alive():
                began_s = time.monotonic()
                terminal.ask(b"p")
                longest_s = max(longest_s, time.monotonic() - began_s)
        waits_s.append(longest_s)
        server.ask("cancel_run", name=f"long{n}", how="prejudice")
        ended(server, f"long{n}")
        after.append(rss_kB())
    assert [answer["state"] for answer in answers] == ["queued"] * 4
    assert min(waits_s) < 0.5, waits_s  # each was over a second where the event loop read the document
    assert after[3] - after[1] < 20_000  # it was 27 MB for each


@pytest.mark.thorough
def test_hundreds_that_wait_for_an_axis_that_is_reset_all_end_with_a_reason(place: Place) -> None:
    server, _ = serve(place, 1, 5)
    names = ["moving", *(f"waiting{n}" for n in range(500))]
    for name in names:
        server.ask("run", text=run(name, {"dwell_s": 600.0}, {"move": {"m1": 90.0}}), file="f", check=False)
    until(lambda: server.ask("runs", name="moving")[0]["state"] == "running", "the first run")
    server.ask("reset", device="m1")
    until(lambda: all(each["ended_at_ns"] for each in server.ask("runs", name="")), "the end of all")
    ends = server.ask("runs", name="")
    assert [each["run"] for each in ends] == names
    assert {each["state"] for each in ends} == {"failed"}
    assert all("m1" in each["why"] for each in ends)
    ends.sort(key=lambda each: each["ended_at_ns"])
    assert [each["run"] for each in ends] == names
    server.stop()
