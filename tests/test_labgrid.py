"""A bench in labgrid: its own coordinator, exporter, client and pytest plugin reserve it and drive it."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place, free_port, until

pytest.importorskip("labgrid", reason="the extra labgrid is not installed")
TOOLS = Path(sys.executable).parent
ENVIRONMENT = """
imports: [hil.labgrid]
targets:
  main:
    resources:
      RemotePlace: {name: press}
    drivers:
      HilBenchDriver: {config: site/clients/ann/zenoh.json}
"""
TEST = """
import pytest
from hil.client import CommandError, connect_sync

def test_turn(target):
    bench = target.get_driver("HilBenchDriver")
    bench.axis("m1").enable()
    assert bench.read("lease")["lease"]["user"] == "ann"
    with connect_sync("press", config="site/clients/bob/zenoh.json") as other:
        with pytest.raises(CommandError, match="ann has this bench"):
            other.axis("m1").enable()
"""


class Grid:
    """Coordinator and exporter in a folder, with a bench behind them."""

    def __init__(self, place: Place) -> None:
        self.place, self.port = place, free_port()
        self.environment = os.environ | {"LG_COORDINATOR": f"127.0.0.1:{self.port}"}
        self.running: list[subprocess.Popen[bytes]] = []

    def start(self, tool: str, *arguments: str) -> "subprocess.Popen[bytes]":
        with (self.place.folder / f"{tool}.log").open("wb") as log:
            command = [str(TOOLS / tool), *arguments]
            started = subprocess.Popen(
                command, stdout=log, stderr=log, cwd=self.place.folder, env=self.environment
            )
        self.running.append(started)
        return started

    def client(self, *words: str) -> str:
        return self.run(str(TOOLS / "labgrid-client"), *words)

    def test(self) -> str:
        (self.place.folder / "test_press.py").write_text(TEST)
        (self.place.folder / "env.yaml").write_text(ENVIRONMENT)
        plain = ("-q", "-p", "no:cacheprovider", "--lg-env", "env.yaml", "test_press.py")
        return self.run(sys.executable, "-m", "pytest", *plain)

    def run(self, *command: str) -> str:
        done = subprocess.run(
            command,
            cwd=self.place.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )
        return done.stdout + done.stderr


@pytest.fixture
def grid(place: Place) -> Iterator[Grid]:
    made = Grid(place)
    try:
        yield made
    finally:
        for each in made.running:
            each.terminate()
            each.wait(PATIENCE_S)


@pytest.mark.thorough
def test_a_place_is_acquired_driven_and_released(grid: Grid) -> None:
    place, port = grid.place, free_port()
    where = ("--bench", "press", "--host", "127.0.0.1", "--port", str(port))
    users = ("--user", "ann:operator", "--user", "bob:operator")
    place.cli("zenoh", "keys", str(place.folder / "site"), *where, *users)
    head = "bench: press\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n"
    server = place.serve(head + (place.folder / "site" / "bridge.yaml").read_text(), bench="press").ready()
    (place.folder / "exporter.yaml").write_text(
        f"press:\n  HilBench: {{bench: press, connect: tls/127.0.0.1:{port}}}\n"
    )
    coordinator = grid.start("labgrid-coordinator", "-l", f"127.0.0.1:{grid.port}")
    until(lambda: "Error" not in grid.client("resources"), "the coordinator")
    grid.start("labgrid-exporter", "--name", "lab1", "exporter.yaml")
    until(lambda: "lab1/press/HilBench" in grid.client("resources"), "the exporter's resource")
    grid.client("-p", "press", "create")
    grid.client("-p", "press", "add-match", "lab1/press/HilBench")
    assert "acquired place press" in grid.client("-p", "press", "acquire")
    assert "1 passed" in grid.test()
    assert "lease of ann given back: labgrid: main" in server.output
    server.stop()
    assert "the bench press cannot be had: " in grid.test()
    assert "released place press" in grid.client("-p", "press", "release")
    coordinator.terminate()
    coordinator.wait(PATIENCE_S)
    assert "coordinator" in grid.test()
