"""The fixture ``lab_bench``: a bench of a live lab by its labels, leased for a test."""

import subprocess
import sys

from e2e_support import PATIENCE_S, Place, free_port

TESTS = """
import pytest

def test_one(lab_bench):
    bench = lab_bench(labels={"rig": "press"})
    assert bench.leased()["why"] == "pytest: test_one"
    bench.axis("m1").enable()

def test_that_fails(lab_bench):
    lab_bench(labels={"rig": "press"})
    raise KeyError("mine")

def test_by_name(lab_bench):
    assert lab_bench("t", doors=["ports"]).leased()["doors"] == ["ports"]

def test_twice(lab_bench):
    lab_bench()
    lab_bench()

def test_other_labels(lab_bench):
    lab_bench(labels={"rig": "mill"})
"""


def run(place: Place, *options: str) -> str:
    (place.folder / "test_lab.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", *options, "test_lab.py"]
    done = subprocess.run(
        command, cwd=place.folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    return done.stdout + done.stderr


def test_a_bench_is_leased_for_each_test_and_given_back(place: Place) -> None:
    assert "5 skipped" in (said := run(place))
    assert "no lab is known: --lab-config or HIL_LAB_CONFIG" in said
    port, folder = free_port(), place.folder / "site"
    where = ("--bench", "t", "--host", "127.0.0.1", "--port", str(port))
    place.cli("zenoh", "keys", str(folder), *where, "--user", "ann:operator", "--user", "bob:operator")
    head = "bench: t\nlabels: {rig: press}\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n"
    server = place.serve(head + (folder / "bridge.yaml").read_text()).ready()
    options = ("--lab-config", "site/clients/ann/zenoh.json")
    said = run(place, *options)
    assert "3 failed, 2 passed" in said
    assert "KeyError: 'mine'" in said
    assert "no bench is free:\nt: you have it already" in said
    assert "no bench of the lab is rig=mill" in said
    assert server.ask("lease") == {"lease": None}
    server.ask("take_lease", why="mine", for_s=600)
    said = run(place, *options, "--lab-wait", "0.1", "-k", "test_one")
    assert "no bench is free:\nt: " in said
    assert "has this bench until" in said
    server.stop()
    assert "the lab is away: tls/127.0.0.1" in run(place, *options, "-k", "test_one")
