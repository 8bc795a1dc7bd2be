"""No operation asks what kind of device it has: a kind has no name in this room."""

import ast
from pathlib import Path

import pytest

MODULES = sorted(Path(__file__).parents[1].glob("*.py"))
KINDS = {"TwinDevice", "BoardDevice", "DriveDevice", "RealDevice", "BoardBackend", "BoardAxis", "TwinAxis"}
KINDS |= {"RealDrive", "DriveControl", "DriveAxis", "UartBackend"}
ASKED = {"boards", "drives", "is_real"}
"""Attributes by which kinds were told apart."""
ROOMS = ("hil.drives", "hil.live.drives", "hil.live.board_backend", "hil.live.sim_backends", "hil.sim.twin")
HERE = "hil.live.devices"
ALL = f"{HERE}.bench_devices"


def kinds_in(text: str) -> list[str]:
    """Kinds of devices that a module names, and modules of them that it imports."""
    found = []
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Name(id=name) | ast.alias(name=name) if name in KINDS:
                found.append(name)
            case ast.Attribute(attr=name) if name in KINDS | ASKED:
                found.append(name)
            case ast.Constant(value=str(name)) if name in KINDS:
                found.append(name)
        if isinstance(node, ast.Import | ast.ImportFrom):
            base = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names = base + [".".join([*base, alias.name]) for alias in node.names]
            found += [name for name in names if _is_of_kind(name)]
    return found


def _is_of_kind(module: str) -> bool:
    if module.startswith(f"{HERE}.") and module != ALL and not module.startswith(f"{ALL}."):
        return True
    return any(module == room or module.startswith(f"{room}.") for room in ROOMS)


def test_no_operation_names_a_kind_of_device() -> None:
    assert len(MODULES) > 10
    assert {path.name: found for path in MODULES if (found := kinds_in(path.read_text()))} == {}


@pytest.mark.parametrize(
    "line",
    [
        "from hil.live.devices.twin_device import TwinDevice",
        "import hil.live.devices.drive_device",
        "from hil.live.devices import board_device",
        "from hil.drives.real_drive import RealDrive as Known",
        "from hil.sim import twin",
        "if isinstance(device, BoardDevice): ...",
        "if type(device).__name__ == 'DriveDevice': ...",
        "if asked.target in places.boards: ...",
        "if device.info('').is_real: ...",
    ],
)
def test_a_planted_kind_is_found(line: str) -> None:
    assert kinds_in(line)
