"""What commands import at their start, which is most of the time that they take."""

import subprocess
import sys
from pathlib import Path

import pytest
from e2e_support import Place, config

MODULES = """
import sys
told, sys.argv = sys.argv[1], ["hil", *sys.argv[2:]]
from hil.cli.entry import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
open(told, "w").write(" ".join(sys.modules))
"""
HEAVY = {
    *("aiohttp", "asyncio", "can", "canopen", "cryptography", "matplotlib", "msgpack", "numpy", "plotext"),
    *("pymodbus", "pytest", "serial", "ssl", "zenoh"),
}
"""Packages that no start needs."""
FOR_PEOPLE = {"rich"}
"""Packages that show things on a terminal."""
OF_PACKAGES = {"email", "zipfile"}
"""Imports of ``importlib.metadata``: entry points of others are looked for by the names of files first."""
OF_CONFIGURATIONS = {"hil.compose", "hil.config", "hil.core", "pydantic", "yaml"}
OF_BENCHES = {
    *("hil.firmware.runtime", "hil.live", "hil.operations", "hil.runs", "hil.sim.bench", "hil.testing"),
    *("virtual_ports.pty.pty_port",),
}
OF_SOME_BENCHES = {
    *("bridges.can.can_model", "bridges.can.can_buses", "hil.config.segment_model"),
    *("bridges.modbus.maps.drive_map_model", "bridges.can.drives", "bridges.modbus.drives"),
    *("hil.vocab.bridge_protocol",),
    *("bridges.modbus.registers", "bridges.modbus.protocol", "device_profiles.sac"),
    *("hil.instruments", "hil.config.dialogue_model"),
}
"""What a bench of one Mechaduino has not: bridges, real drives, maps, tables, wires, segments, CAN buses."""


def imported(folder: Path, *arguments: str) -> set[str]:
    """Modules that a command has imported when it ends, and packages of any depth that they are in."""
    told = folder / "modules"
    command = [sys.executable, "-c", MODULES, str(told), *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(told.read_text().split())


@pytest.mark.parametrize(
    "arguments", [("--version",), ("--help",), ("list",), ("_names", "benches"), ("serve", "--help")]
)
def test_what_reads_no_configuration(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    where = ("--runtime-dir", str(tmp_path)) if arguments == ("list",) else ()
    modules = imported(tmp_path, *arguments, *where)
    assert modules & (HEAVY | OF_CONFIGURATIONS | OF_BENCHES | FOR_PEOPLE) == set()


def test_the_version_alone(tmp_path: Path) -> None:
    assert imported(tmp_path, "--version") & {"inspect", "typer"} == set()


def test_what_asks_a_bench(place: Place) -> None:
    place.serve(config())
    unneeded = HEAVY | OF_CONFIGURATIONS | OF_BENCHES | FOR_PEOPLE | OF_PACKAGES | {"hil.vocab.bus"}
    for command in ("status", "list"):
        modules = imported(place.folder, command, "--runtime-dir", str(place.runtime))
        assert modules & unneeded == set()


def test_a_check_of_a_small_bench(tmp_path: Path) -> None:
    file = tmp_path / "bench.yaml"
    file.write_text("bench: b\ndevices: {m1: {profile: mechaduino}}\n")
    modules = imported(tmp_path, "check", str(file))
    assert modules & (HEAVY | OF_BENCHES | OF_SOME_BENCHES | FOR_PEOPLE | OF_PACKAGES | {"logging"}) == set()


def test_a_check_of_bridges(tmp_path: Path) -> None:
    """Their options are read, and nothing that serves."""
    file = tmp_path / "bench.yaml"
    file.write_text(
        "bench: b\n"
        "devices: {m1: {profile: mechaduino}}\n"
        "can: {can0: {nodes: {m1: 5}}}\n"
        "bridges: {can: {channels: {can0: {interface: virtual}}}, metrics: {}, modbus: {}, web: {},"
        " zenoh: {}}\n"
    )
    modules = imported(tmp_path, "check", str(file))
    assert modules & (HEAVY | OF_BENCHES) == set()


def test_an_editable_install_has_no_import_finder() -> None:
    """It would be imported by each Python in the venv, before any command."""
    finders = [name for name in sys.modules if name.startswith("__editable__")]
    assert finders == []


def test_the_kit_imports_what_a_bench_in_memory_needs() -> None:
    program = "import hil.testing, sys; print(*sys.modules)"
    said = set(subprocess.check_output([sys.executable, "-c", program], text=True).split())
    assert {"hil.testing.bench", "hil.sim.bench", "serial"} <= said
    late = {"hil.runs", "hil.toolpath", "hil.testing.drawings", "hil.testing.served_bench"}
    assert not said & (HEAVY - {"serial"} | late)
