"""`hil log`: of a bench that runs, of its next run, of a killed one, and of one without a recording."""

import json
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, until

BENCH = "bench: t\ndevices:\n  m1: {profile: mechaduino}\n  s1: {profile: sac}\n"
WARNING = "WARNING: Lookup table is empty! Run calibration"


@pytest.fixture
def place() -> Iterator[Place]:
    with Place() as made:
        yield made


def told(place: Place, *words: str) -> list[dict[str, Any]]:
    said = place.cli("log", *words, "--lines", "0", "--json", *place.folders())
    return [json.loads(line) for line in said.splitlines() if line.startswith("{")]


def texts(rows: list[dict[str, Any]]) -> list[tuple[str, str]]:
    return [(row["source"], row["text"]) for row in rows]


@pytest.mark.long
def test_a_bench_that_runs_then_was_killed(place: Place) -> None:
    server = place.serve(BENCH).ready()
    server.ask("inject", fault="byte_drop", target="s1", parameters={"rate": 0.5, "for_s": 0.1})
    until(lambda: ("m1", WARNING) in texts(told(place)), "what a board printed and nobody read")
    until(lambda: any(row["kind"] == "faults" for row in told(place)), "a fault in the recording")
    rows = told(place)
    assert [row["at_ns"] for row in rows] == sorted(row["at_ns"] for row in rows)
    assert ("s1", "SAC 1.0") in texts(rows)
    faults = [row for row in rows if row["kind"] == "faults"]
    assert faults[0]["level"] == "warning"
    assert faults[0]["text"].startswith("fault byte_drop")
    assert {row["source"] for row in told(place, "m1")} == {"m1"}
    assert all(row["level"] != "info" for row in told(place, "--level", "warning"))
    assert 'did you mean "m1"?' in place.cli("log", "m11", *place.folders(), code=2)
    assert place.cli("log", "--lines", "1", *place.folders()).count("\n") == 1
    server.kill()
    assert set(texts(rows)) <= set(texts(told(place)))
    assert "t does not run; its run " in place.cli("log", *place.folders())
    assert set(texts(rows)) <= set(texts(told(place, "--recording", "last")))


@pytest.mark.long
def test_the_next_run_is_followed(place: Place) -> None:
    server = place.serve(BENCH).ready("s1", boot_ns=10**9)
    command = [HIL, "log", "--follow", "--json", *place.folders()]
    with (place.folder / "out").open("wb") as out:
        following = subprocess.Popen(command, stdout=out, stderr=out)
    try:
        until(lambda: b"SAC 1.0" in (place.folder / "out").read_bytes(), "the first run")
        server.stop()
        place.serve(BENCH)
        until(lambda: (place.folder / "out").read_bytes().count(b"SAC 1.0") == 2, "the next run")
        assert b"the bench began again" in (place.folder / "out").read_bytes()
    finally:
        following.terminate()
        following.wait(PATIENCE_S)


@pytest.mark.long
def test_a_warning_of_the_daemon_and_a_bench_without_a_recording(place: Place) -> None:
    text = BENCH + "recordings: {keep_runs: 0}\n"
    server = place.serve(text)
    server.ask("inject", fault="shaft_jam", target="s1", parameters={})
    said = place.cli("log", *place.folders())
    assert "this run is not recorded" in said
    assert "fault shaft_jam" in said
