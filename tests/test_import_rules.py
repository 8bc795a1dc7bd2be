"""Imports that the signs on the doors do not allow, planted all at once in a copy: each is found, and nothing
else."""

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from import_rules import EACH_MAY, MAY, House, signs_in

ROOT = Path(__file__).parents[1]
ROOTS = sorted(init.parent.name for init in ROOT.glob("*/__init__.py"))


class Plant(NamedTuple):
    """Modules by path, and the beginning of the one line that is found then."""

    files: dict[str, str]
    found: str


def planted(module: str, imported: str, form: str = "import {}\n") -> Plant:
    """A new module that imports something."""
    return Plant({f"{module.replace('.', '/')}.py": form.format(imported)}, f"{module} imports {imported},")


def kind(module: str, imported: str) -> Plant:
    """A new kind of board, port or bridge whose only module imports something."""
    plant = planted(module, imported)
    folder = module.rpartition(".")[0].replace(".", "/")
    return plant._replace(files={f"{folder}/__init__.py": '"""A new kind."""\n', **plant.files})


def compiled(module: str, text: str, imported: str) -> Plant:
    """A new compiled module whose source has this text."""
    path = module.replace(".", "/")
    return Plant({f"{path}.pyx": text, f"{path}.pyi": ""}, f"{module} imports {imported},")


TYPES = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import {}\n"
LATER = "def run() -> None:\n    import {}\n"
PLANTS = {
    # boards
    "board to board": planted("device_profiles.sac.new", "device_profiles.mechaduino.firmware"),
    "board to runs": planted("device_profiles.mechaduino.new", "hil.runs"),
    "board to telemetry": planted("device_profiles.mechaduino.new2", "hil.telemetry"),
    "board to chance": planted("device_profiles.sac.new2", "random"),
    "board to a package": planted("device_profiles.sac.new3", "zenoh"),
    "board to the compiled core": planted("device_profiles.sac.new4", "hil.core._native"),
    "new board to core": kind("device_profiles.new.firmware", "hil.core"),
    "new board to clock": kind("device_profiles.new.firmware2", "time"),
    "a board's test to live": planted("device_profiles.sac.tests.test_new", "hil.live.store"),
    # ports
    "port to telemetry": planted("virtual_ports.pty.new", "hil.telemetry"),
    "port to port": planted("virtual_ports.tcp.new", "virtual_ports.pty.port"),
    "port to sim": planted("virtual_ports.serial.new", "hil.sim.inputs"),
    "new port to pty": kind("virtual_ports.new.port", "virtual_ports.pty.port"),
    "wire to asyncio": planted("virtual_ports.rs485.new", "asyncio"),
    "a port's test to another's": planted("virtual_ports.tcp.tests.test_new", "virtual_ports.pty.port"),
    # bridges
    "bridge to runs": planted("bridges.metrics.new", "hil.runs"),
    "bridge to client": planted("bridges.metrics.new2", "hil.client"),
    "bridge to bridge": planted("bridges.metrics.new3", "bridges.zenoh.keys"),
    "bridge to board": planted("bridges.zenoh.new", "device_profiles.sac"),
    "new bridge to operations": kind("bridges.new.bridge", "hil.operations"),
    # pure rooms
    "sim to asyncio": planted("hil.sim.new", "asyncio"),
    "sim to clock": planted("hil.sim.new2", "time"),
    "sim to system": planted("hil.sim.new3", "os"),
    "sim to threads": planted("hil.sim.new4", "threading"),
    "sim to chance": planted("hil.sim.new5", "random"),
    "vocab to socket": planted("hil.vocab.new", "socket"),
    "wire to clock": planted("hil.wire.new", "time"),
    "firmware to asyncio": planted("hil.firmware.new", "asyncio"),
    "core to clock": planted("hil.core.new", "time"),
    "runs to clock": planted("hil.runs.new", "time"),
    # upwards
    "vocab to wire": planted("hil.vocab.new2", "hil.wire.pcapng"),
    "firmware to sim": planted("hil.firmware.new2", "hil.sim.uart"),
    "core to sim": planted("hil.core.new2", "hil.sim"),
    "telemetry to sim": planted("hil.telemetry.new", "hil.sim.bench"),
    "sim to compose": planted("hil.sim.new6", "hil.compose"),
    "config to runs": planted("hil.config.new", "hil.runs"),
    "config to compose": planted("hil.config.new2", "hil.compose"),
    "runs to live": planted("hil.runs.new2", "hil.live.guard"),
    "host to live": planted("hil.host.new", "hil.live.guard"),
    "net to operations": planted("hil.net.new", "hil.operations.health"),
    "live to operations": planted("hil.live.new", "hil.operations.health"),
    "live to cli": planted("hil.live.new2", "hil.cli.bench.views"),
    "health to daemon": planted("hil.operations.new", "hil.daemon"),
    "client to sim": planted("hil.client.new", "hil.sim.inputs"),
    "arduino to live": planted("hil.arduino.new", "hil.live.store"),
    "testing to daemon": planted("hil.testing.new", "hil.daemon"),
    "daemon's room to board": planted("hil.live.new3", "device_profiles.sac"),
    "compose to port": planted("hil.compose.new", "virtual_ports.pty.port"),
    # whatever form it has
    "for types alone": planted("hil.sim.new7", "hil.live.guard", TYPES),
    "when it runs": planted("hil.host.new2", "hil.sim.bench", LATER),
    "relative": planted("hil.sim.new8", "hil.live.guard", "from ..live import guard  # {}\n"),
    "a name of a module": planted("hil.wire.new2", "hil.sim.uart", "from {} import DeviceUart\n"),
    # compiled
    "Cython to clock": compiled("hil.wire._new", "import time\n", "time"),
    "Cython to C's clock": compiled("hil.wire._new2", "from libc.time cimport time\n", "time"),
    "Cython upwards": compiled("hil.wire._new3", "from hil.sim.uart cimport DeviceUart\n", "hil.sim.uart"),
    # rooms in rooms, private names, tests
    "drives to runs in live": planted("hil.live.devices.new", "hil.live.runs.queue"),
    "faults to firmware in sim": planted("hil.sim.faults.new", "hil.firmware.runtime"),
    "a test in sim to operations": planted("hil.sim.tests.test_new", "hil.operations.health"),
    "operations to a kind of device": planted("hil.operations.new2", "hil.live.devices.twin_device"),
    "a private name": planted(
        "hil.operations.new3", "hil.live.places._joined", "from hil.live.places import _joined  # {}\n"
    ),
    # around the signs
    "a room without a sign": Plant({"hil/attic/__init__.py": '"""Old things."""\n'}, "hil.attic has no sign"),
    "a module without a sign": Plant({"hil/loft.py": '"""Old things."""\n'}, "hil.loft has no sign"),
    "a folder that is no package": Plant(
        {"hil/sim/attic/new.py": "import time\n"}, "hil.sim.attic.new is in a folder without __init__.py"
    ),
    "a sign for nothing": Plant(
        {"hil/shed.py": '"""Old.\n\nMay import: hil.cellar.\n"""\n'},
        "the sign of hil.shed allows hil.cellar, which does not exist",
    ),
    "circle of two": Plant(
        {"hil/sim/round1.py": "import hil.sim.round2\n", "hil/sim/round2.py": "import hil.sim.round1\n"},
        "these import each other: hil.sim.round1, hil.sim.round2",
    ),
    "circle for types": Plant(
        {
            "hil/live/round1.py": "import hil.live.round2\n",
            "hil/live/round2.py": TYPES.format("hil.live.round3"),
            "hil/live/round3.py": LATER.format("hil.live.round1"),
        },
        "these import each other: hil.live.round1, hil.live.round2, hil.live.round3",
    ),
    "circle by the package": Plant(
        {
            "hil/live/ring/__init__.py": "from hil.live.ring import a\n",
            "hil/live/ring/a.py": "import hil.live.ring\n",
        },
        "these import each other: hil.live.ring, hil.live.ring.a",
    ),
}


def files() -> Iterator[tuple[str, str]]:
    """Paths and texts of all plants."""
    for plant in PLANTS.values():
        yield from plant.files.items()


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    """Findings in a copy as it is, and with all plants: a look at the whole tree takes a second."""
    copy = tmp_path_factory.mktemp("copy")
    for source in [path for root in ROOTS for path in (ROOT / root).rglob("*.p[yx]*")]:
        if source.suffix in (".py", ".pyi", ".pyx", ".pxd"):
            target = copy / source.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
    for name in ("import_rules.py", "pyproject.toml"):
        shutil.copy(ROOT / name, copy)
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name("plant_imports.py")],
        input=json.dumps(dict(files())),
        cwd=copy,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: list[list[str]] = json.loads(done.stdout.splitlines()[-1])
    return found


def test_the_tree_keeps_its_contracts(answers: list[list[str]]) -> None:
    assert answers[0] == []


def test_plants_do_not_touch_each_other() -> None:
    """A file of two plants is the same in both, as a new folder's ``__init__.py``."""
    texts = dict(files())
    assert [name for name, text in files() if texts[name] != text] == []


@pytest.mark.parametrize("sort", PLANTS)
def test_a_planted_import_is_found(answers: list[list[str]], sort: str) -> None:
    found = {line for line in answers[1] if line.startswith(PLANTS[sort].found)}
    assert len(found) == 1, (found, answers[1])


def test_nothing_but_what_was_planted_is_found(answers: list[list[str]]) -> None:
    planted = tuple(plant.found for plant in PLANTS.values())
    assert [line for line in answers[1] if not line.startswith(planted)] == answers[0]


def said_in_contributing() -> dict[str, set[str]]:
    """Rooms that each folder may import, by the table."""
    table = (ROOT / "CONTRIBUTING.md").read_text().partition("\n## Commands")[0]
    rooms: dict[str, set[str]] = {}
    for folder, names in re.findall(r"^\| `([\w/]+)(?:\.py|/<x>)?` \|.*\| (.*) \|$", table, re.MULTILINE):
        above = {room for room in rooms if room.count(".") == 1}
        named = {f"hil.{name}" for name in re.findall(r"`(\w+)`", names)}
        rooms[folder.replace("/", ".")] = above if names == "all above" else named
    return rooms


def test_contributing_says_what_the_signs_say() -> None:
    said = said_in_contributing()
    for module, path in House([*ROOTS]).files.items():
        sign = signs_in(path.read_text()).get(EACH_MAY if module in ROOTS else MAY)
        if sign is not None and (module in said or re.fullmatch(r"hil\.\w+", module)):
            rooms = {".".join(name.split(".")[:2]) for name in sign if name.startswith("hil.")}
            assert said.pop(module) == rooms, module
    assert not any(said.values()), "folders that have no sign"
