"""Real modules as axes. Those of a bench that is served stand for them: the line is the pty of its tap."""

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse
from hil.testing import LiveError, ServedBench, live
from hil.wire.address_keys import AddressRefused
from tmcl_bus.drives.tmcl_drive_address import SerialPlace, TmclDriveAddress, tmcl_drive_address

BENCH = Path(__file__).parents[1] / "bench.yaml"


@pytest.fixture(scope="module")
def line() -> Iterator[ServedBench]:
    with live(BENCH) as served:
        yield served


@pytest.fixture(scope="module")
def bench(line: ServedBench) -> Iterator[ServedBench]:
    at = f"tmcl+serial://{line.port('bus0.master')}?baud=9600&module="
    modules = {"x": 1, "y": 3, "nobody": 9}
    devices = {name: {"profile": "tmcl_drive", "at": f"{at}{number}"} for name, number in modules.items()}
    with live({"bench": "real", "devices": devices}) as served:
        yield served


def until(condition: Callable[[], Any]) -> None:
    end_s = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.05)


def degrees(bench: ServedBench, name: str) -> float:
    return float(json.loads(bench.hil("status", name, "--json"))[name]["position_deg"])


def is_there(bench: ServedBench, *names: str) -> bool:
    states = [json.loads(bench.hil("status", name, "--json"))[name] for name in names]
    return all(state["connected"] for state in states)


@pytest.mark.parametrize(("name", "twin"), [("x", "m1"), ("y", "s1")])
def test_verbs_move_the_motor_behind_the_line(
    line: ServedBench, bench: ServedBench, name: str, twin: str
) -> None:
    until(lambda: is_there(bench, name))
    from_deg, began_deg = degrees(bench, name), degrees(line, twin)
    bench.hil("axis", name, "move-rel", "90", "velocity_rpm=120", "--wait")
    assert degrees(bench, name) == pytest.approx(from_deg + 90, abs=1)
    assert degrees(line, twin) == pytest.approx(began_deg + 90, abs=2.5)
    bench.hil("axis", name, "move-abs", "3600", "velocity_rpm=60")
    bench.hil("axis", name, "stop", "--wait")
    until(lambda: not json.loads(bench.hil("status", name, "--json"))[name]["moving"])
    assert degrees(bench, name) < 3000


def test_what_a_module_refuses_is_told(bench: ServedBench) -> None:
    until(lambda: is_there(bench, "x"))
    with pytest.raises(LiveError, match="invalid value MVP"):
        bench.hil("axis", "x", "move-abs", "0", "velocity_rpm=90000")
    assert "x" in bench.hil("status")


def test_a_module_that_does_not_reply_is_told_and_the_others_are_there(bench: ServedBench) -> None:
    until(lambda: "no reply within" in str(bench.ask("status")))
    assert not is_there(bench, "nobody")
    until(lambda: is_there(bench, "x", "y"))


def test_addresses() -> None:
    at = "tmcl+serial:///dev/ttyUSB0?module=7&baud=115200&host=3"
    assert tmcl_drive_address(at) == TmclDriveAddress(SerialPlace("/dev/ttyUSB0", 115_200), 7, 3)


@pytest.mark.parametrize(
    "at",
    [
        "tmcl+tcp:///dev/ttyUSB0?module=1",
        "tmcl+serial://dev?module=1",
        "tmcl+serial:///dev/ttyUSB0",
        "tmcl+serial:///dev/ttyUSB0?module=256",
        "tmcl+serial:///dev/ttyUSB0?module=1&baud=1",
        "tmcl+serial:///dev/ttyUSB0?module=1&unit=1",
    ],
)
def test_addresses_that_cannot_be_used(at: str) -> None:
    with pytest.raises(AddressRefused):
        tmcl_drive_address(at)


def test_two_modules_with_one_address_are_refused() -> None:
    device = {"profile": "tmcl_drive", "at": "tmcl+serial:///dev/ttyUSB0?module=1"}
    text = json.dumps({"bench": "t", "devices": {"x": device, "y": device}})
    with pytest.raises(ConfigError, match="module 1"):
        parse(text, "bench.yaml", find_catalogue())


def test_a_twin_of_it_is_a_servo() -> None:
    parse('{"bench": "t", "devices": {"x": {"profile": "tmcl_drive"}}}', "bench.yaml", find_catalogue())
