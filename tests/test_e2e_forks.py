"""Benches that go on from a recording: exact at their time, by themselves from there, beside the original."""

import json
import time
from pathlib import Path

import pytest
from e2e_support import Place, Server, config, until

from hil.net.control_client import ControlError
from hil.recorded.bench_then import bench_then
from hil.recorded.recorded_run import open_recorded
from hil.recorded.time_words import parse_time
from hil.testing import Bench
from hil.vocab.time import SimTimeNs

DEVICES = {"m1": {}, "s1": {"profile": "sac", "flash": {}}}
MOVE = b"xyr90\r"


def recorded(place: Place, *, kill: bool = True, **top: object) -> tuple[Server, Path]:
    """A bench with a log, on which m1 was moved."""
    log = place.folder / "run.hil"
    server = place.serve(config(speed=5, devices=DEVICES, **top), "--log", str(log)).ready()
    with server.client("m1") as client:
        client.write(MOVE)
        client.read_until(b"90.00")
    until(lambda: abs(server.status()["snapshot"]["position_deg"] - 90) < 2, "the move")
    if kill:
        time.sleep(0.5)  # the log has what is older than 0.2 s
        server.kill()
    return server, log


def at_end(log: Path, back: str = "-0.1s") -> tuple[SimTimeNs, dict[str, float]]:
    """A time of a recording, and m1's state then."""
    run = open_recorded(log)
    at_ns = parse_time(back, run.end_ns)
    return at_ns, bench_then(run, at_ns).axes["m1"]


def identical(place: Place, log: Path) -> str:
    said = place.cli("replay", str(log))
    assert said.startswith("identical"), said
    return said


def test_a_killed_bench_goes_on_from_its_end(place: Place) -> None:
    _, log = recorded(place)
    at_ns, state = at_end(log)
    own = place.folder / "fork.hil"
    fork = place.fork(log, "--until", "-0.1s", "--pause", "--log", str(own))
    told = fork.ask("status")
    assert told["bench"] == "t-replay"
    assert told["sim_ns"] == at_ns
    assert told["is_paused"]
    assert told["recording"]["forked_from"].startswith(f"{log} at ")
    assert fork.ask("state", device="m1") == state
    text = place.cli("status", "--bench", "t-replay")
    assert "a fork of" in text
    assert "hil resume" in text.replace(f" --runtime-dir {place.runtime}", "")
    with fork.client("m1") as client, fork.client("s1") as other:
        client.write(b"p")
        other.write(b"\r")
        time.sleep(0.3)
        assert client.quiet(0) == b"" == other.quiet(0)
        assert fork.ask("state", device="m1") == state
        fork.ask("resume")
        assert b"Angle: 8" in (said := client.read_until(b"\n")) or b"Angle: 9" in said
        other.read_until(b"SAC>")
        fork.ask("pause")
        stands_ns = fork.ask("status")["sim_ns"]
        client.write(b"p")
        time.sleep(0.2)
        assert client.quiet(0) == b""
        assert fork.ask("status")["sim_ns"] == stands_ns
        fork.ask("resume")
        client.read_until(b"\n")
    assert fork.ask("status")["sim_ns"] > stands_ns
    fork.stop()
    assert "cut" not in identical(place, own)
    assert open_recorded(own).log.forked_from.startswith(f"{log} at ")


def test_a_fork_runs_beside_the_live_original(place: Place) -> None:
    server, log = recorded(place, kill=False, bridges={"metrics": {"listen": "127.0.0.1:0"}})
    until(lambda: open_recorded(log).log.inputs, "the log")
    own = place.folder / "fork.hil"
    fork = place.fork(log, "--log", str(own), "--page")
    for bench in (server, fork):
        with bench.client("m1") as client:
            client.write(b"p")
            client.read_until(b"Angle")
    assert set(fork.ask("status")["bridges"]) == {"metrics", "web"}
    second = place.fork(log, "--name", "other", bench="other")
    assert second.ask("list")["bench"] == "other"
    assert server.ask("list")["bench"] == "t"
    for bench in (second, fork, server):
        bench.stop()
    assert {each.name for each in place.state.iterdir()} == {"t", "t-replay", "other"}
    identical(place, log)
    identical(place, own)


def test_a_fork_has_the_events_of_the_recording(place: Place) -> None:
    log = place.folder / "run.hil"
    server = place.serve(config(speed=5, devices=DEVICES), "--log", str(log)).ready()
    server.ask("do", device="m1", name="enable", parameters={})
    with pytest.raises(ControlError, match="no_such"):
        server.ask("do", device="m1", name="no-such", parameters={})
    listed = server.ask("events", after=0)["events"]
    assert [row["kind"] for row in listed] == ["verbs", "refusals"]
    server.stop()
    found = json.loads(place.cli("replay", str(log), "--events", "--json"))
    assert found[:2] == [{name: row[name] for name in found[0]} for row in listed]
    said = place.cli("replay", str(log), "--events").splitlines()
    assert "enable" in said[0]
    assert "no_such" in said[1]
    fork = place.fork(log, "--pause")
    assert fork.ask("events", after=0)["events"][:2] == listed
    fork.stop()
    identical(place, log)


@pytest.mark.thorough
def test_a_fork_of_a_fork(place: Place) -> None:
    _, log = recorded(place)
    first = place.folder / "first.hil"
    fork = place.fork(log, "--log", str(first))
    with fork.client("m1") as client:
        client.write(b"r10\r")
        client.read_until(b"10.00")
    until(lambda: abs(fork.status()["snapshot"]["position_deg"] - 10) < 2, "the move")
    fork.kill()
    at_ns, state = at_end(first)
    second = place.folder / "second.hil"
    again = place.fork(first, "--until", "-0.1s", "--pause", "--log", str(second))
    assert again.ask("status")["sim_ns"] == at_ns
    assert again.ask("state", device="m1") == state
    again.ask("resume")
    again.stop()
    identical(place, first)
    identical(place, second)


@pytest.mark.thorough
def test_a_memory_that_was_written_is_in_the_fork_and_the_originals_file_stays(place: Place) -> None:
    log = place.folder / "run.hil"
    text = config(speed=20, devices={"m1": {"flash": {"table": "empty"}}})
    server = place.serve(text, "--log", str(log)).ready()
    server.ask("do", device="m1", name="calibrate", parameters={})
    until(lambda: (place.state / "t" / "m1.nvm").exists(), "the calibration")
    time.sleep(0.5)
    server.kill()
    stored = (place.state / "t" / "m1.nvm").read_bytes()
    own = place.folder / "fork.hil"
    fork = place.fork(log, "--log", str(own))
    assert not (place.state / "t-replay" / "m1.nvm").exists()
    with fork.client("m1") as client:
        client.quiet(0.2)
        begun_ns = fork.ask("status")["sim_ns"]
        fork.ask("reset", device="m1")
        fork.ready("m1", begun_ns)
        said = client.quiet(0.2)
        assert b"Main menu" in said
        assert b"WARNING" not in said
        fork.ask("do", device="m1", name="calibrate", parameters={})
        until(lambda: (place.state / "t-replay" / "m1.nvm").exists(), "the fork's own calibration")
    fork.stop()
    assert (place.state / "t" / "m1.nvm").read_bytes() == stored
    identical(place, own)


def test_a_changed_bench_goes_on(place: Place) -> None:
    _, log = recorded(place)
    own = place.folder / "fork.hil"
    fork = place.fork(log, "--set", "m1.pKp=10", "--log", str(own))
    assert fork.ask("state", device="m1")["pKp"] == 10
    fork.stop()
    identical(place, own)


def test_a_fork_begins_before_a_reload(place: Place) -> None:
    server, log = recorded(place, kill=False)
    text = config(speed=5, devices=DEVICES | {"m1": {"spi_previous_command": 0}})
    place.write(text, "t.yaml")
    server.ask("reload")
    server.stop()
    said = place.cli("replay", str(log), "--serve", *place.folders(), code=2)
    assert "was reloaded at" in said
    assert "give an earlier --until" in said
    assert place.fork(log, "--until", "3s", "--pause").ask("status")["sim_ns"] == 3_000_000_000


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--serve", "--until", "9h"), "is not within the run"),
        (("--pause",), "is for a bench that goes on: give --serve too"),
        (("--serve", "--from", "1s"), "leave --from and --to out"),
        (("--serve", "--name", "Not A Name"), "is not a name"),
        (("--serve", "--set", "m1.pKq=1"), 'did you mean "m1.pKp"'),
    ],
)
def test_forks_that_cannot_be(place: Place, options: tuple[str, ...], said: str) -> None:
    log = place.folder / "run.hil"
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench, log.open("w") as file:
        bench.start()
        bench.inputs.write_to(file)
    assert said in place.cli("replay", str(log), *options, *place.folders(), code=2)


def test_real_boards_cannot_stand(place: Place) -> None:
    real = {"profile": "mechaduino", "at": str(place.folder / "none"), "baud": 9600}
    devices = {"m1": {"profile": "mechaduino", "port": "pty"}, "r1": real}
    server = place.serve(json.dumps({"bench": "t", "devices": devices}))
    said = place.cli("pause", "--runtime-dir", str(place.runtime), code=1)
    assert "r1: the time of what is real cannot stand" in said
    assert not server.ask("status")["is_paused"]
