"""Lanes of a bench: what the environment wants, and that nothing depends on them."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from hil.compose.lanes import LanesRefused, choose_lanes
from hil.core import Core
from hil.core.abi import Lanes
from hil.sim import bench as bench_runtime
from hil.sim.group import Group
from hil.testing import Bench
from hil.vocab.time import SimTimeNs

HERE = [each for each in Lanes if each <= Core(1).native.lanes]
"""Lanes that this processor has."""
SEEDS = 6


def test_the_widest_is_the_default() -> None:
    core = Core(1)
    choose_lanes(core, {})
    assert core.native.lanes == HERE[-1] >= Lanes.any


@pytest.mark.parametrize("lanes", HERE)
def test_a_variable_chooses(lanes: Lanes) -> None:
    core = Core(1)
    choose_lanes(core, {"HIL_LANES": lanes.name})
    assert core.native.lanes == lanes


def test_a_name_that_there_is_not_is_refused() -> None:
    wanted = "HIL_LANES: there are no lanes 'wide': use none, any, avx2 or avx512"
    with pytest.raises(LanesRefused, match=wanted):
        choose_lanes(Core(1), {"HIL_LANES": "wide"})


@pytest.mark.parametrize("lanes", Lanes)
def test_instructions_that_the_processor_lacks_are_refused(lanes: Lanes) -> None:
    if lanes in HERE:
        pytest.skip(f"this processor has {lanes.name}")
    wanted = f"does not have the instructions of the lanes {lanes.name}: use none"
    with pytest.raises(LanesRefused, match=wanted):
        choose_lanes(Core(1), {"HIL_LANES": lanes.name})


def config(chance: random.Random) -> dict[str, Any]:
    """Boards of chance, alone, on lines and on a CAN bus."""
    names = [f"m{number}" for number in range(chance.randrange(5, 20))]
    devices: dict[str, Any] = {
        name: {
            "profile": "mechaduino",
            "port": "memory",
            "plant": chance.choice(("simple", "full")),
            "flash": {"table": "identity"},
        }
        for name in names
    }
    on_bus = chance.sample(names, chance.randrange(len(names)))
    made: dict[str, Any] = {"bench": "lanes", "seed": chance.randrange(99), "devices": devices}
    if on_bus:
        made["can"] = {"can0": {"nodes": {name: number for number, name in enumerate(on_bus, 1)}}}
    for number in range(chance.randrange(3)):
        devices[f"s{number}"] = {"profile": "sac", "port": "memory"}
    return made


def things(chance: random.Random, bench: Bench, names: list[str]) -> Callable[[], None]:
    """Something that a test does, of chance."""
    name = chance.choice(names)
    port = bench.port(name)
    typed = chance.choice((b"x", b"y", b"n", b"v", b"p", b"r%d\n" % chance.randrange(-720, 720), b"j"))
    text = typed if name.startswith("m") else chance.choice((b"?\r", b"\r", b"x"))
    kind = chance.choice(("shaft_jam", "encoder_freeze", "shaft_load"))
    parameters = {"torque_Nm": 0.05} if kind == "shaft_load" else {}

    def fault() -> None:
        if name.startswith("m"):
            bench.fault(kind, name, **parameters)  # type: ignore[arg-type]

    return chance.choice((lambda: port.write(text), lambda: port.write(text), fault))


def played(seed: int) -> list[Any]:
    """All that a bench of chance shows while chance plays with it."""
    chance, shown = random.Random(seed), list[Any]()
    made = config(chance)
    with Bench(made) as bench:
        names = [*made["devices"]]
        bench.run_until(4500)
        for name in names:
            if name.startswith("m"):
                bench.port(name).write(b"xy" if chance.random() < 0.8 else b"y")
        for _ in range(25):
            bench.run(chance.choice((0.5, 3, 20, 20, 250)) * chance.random())
            things(chance, bench, names)()
            shown += [bench.axis(name).snapshot().as_dict() for name in chance.sample(names, 2)]
        bench.run(300)
        for name in names:
            shown += [bench.axis(name).snapshot().as_dict(), bench.port(name).read_complete()]
    return shown


@pytest.mark.long
@pytest.mark.parametrize("seed", range(SEEDS))
def test_lanes_change_nothing(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Snapshots, bytes and their times are the same with any lanes, and in one group after the other."""
    monkeypatch.setenv("HIL_LANES", Lanes.none.name)
    alone = repr(played(seed))
    for lanes in HERE[1:]:
        monkeypatch.setenv("HIL_LANES", lanes.name)
        assert repr(played(seed)) == alone, lanes.name
    monkeypatch.setattr(bench_runtime, "advance_together", one_by_one)
    assert repr(played(seed)) == alone


def one_by_one(core: Core, groups: list[Group], until_ns: SimTimeNs) -> None:
    for group in groups:
        group.advance(until_ns)
