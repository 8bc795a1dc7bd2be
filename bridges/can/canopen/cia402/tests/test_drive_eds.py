"""EDS files of drives, by the reader of the ``canopen`` library and by the tools of Lely's masters."""

import io
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from canopen.objectdictionary.eds import import_eds
from drive_rig import STEPPER, SimpleAxis, Switch

from bridges.can.canopen.cia402.profile_drive import ProfileDrive
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import Identity
from bridges.can.canopen.node.eds import eds_text

NODE = 5
IDENTITY = Identity(0x1122, 402, 1, 7, "drive")
SWITCHES: dict[str, Switch] = {name: lambda deg: False for name in ("home", "negative", "positive")}
AXES = {
    "servo": SimpleAxis(switches=SWITCHES),
    "stepper": SimpleAxis(verbs=STEPPER, follows_paths=False, index_deg=None),
}
TOOLS = Path(sys.executable).parent
GONE = """
from importlib import import_module
from pathlib import Path
def resource_filename(name, file):
    return str(Path(import_module(name).__file__).parent / file)
"""
"""What the tools use of ``pkg_resources``, which newer setuptools have no more."""


def node_of(kind: str) -> CanOpenNode:
    axis = AXES[kind]
    return CanOpenNode(
        NODE, 1_000_000, lambda services: ProfileDrive(axis, services), IDENTITY, lambda frame: None
    )


@pytest.mark.parametrize("kind", AXES)
def test_the_reader_finds_the_table(kind: str) -> None:
    node = node_of(kind)
    found = import_eds(io.StringIO(eds_text(node.dictionary, IDENTITY, "drive.eds")), NODE)
    for entry in node.dictionary.entries.values():
        variable = found.get_variable(entry.index, entry.subindex)
        assert variable is not None, hex(entry.index)
        assert variable.name == entry.name
        assert variable.data_type == entry.data_type
        if isinstance(entry.default, int):
            assert variable.default == entry.default + NODE * entry.adds_node_id
            assert (variable.min, variable.max) == (entry.low, entry.high)


@pytest.mark.parametrize("kind", AXES)
def test_the_tools_of_another_master_take_it(kind: str, tmp_path: Path) -> None:
    text = eds_text(node_of(kind).dictionary, IDENTITY, "drive.eds")
    (tmp_path / "drive.eds").write_text(text)
    of_node = {
        "dcf": "drive.eds",
        "node_id": NODE,
        "sdo": [
            {"index": 0x6081, "sub_index": 0, "value": 1000},
            {"index": 0x6098, "sub_index": 0, "value": 35},
        ],
        "tpdo": {
            1: {"enabled": True, "transmission": 1, "mapping": [{"index": 0x6041}, {"index": 0x6064}]},
        },
        "rpdo": {
            1: {"enabled": True, "transmission": 1, "mapping": [{"index": 0x6040}, {"index": 0x607A}]},
        },
    }
    bus = {"master": {"node_id": 1, "sync_period": 10_000}, "drive": of_node}
    (tmp_path / "bus.yml").write_text(yaml.safe_dump(bus))
    (tmp_path / "pkg_resources.py").write_text(GONE)
    for command in (["dcfchk", "-n", str(NODE), "drive.eds"], ["dcfgen", "-r", "bus.yml"]):
        done = subprocess.run(
            [TOOLS / command[0], *command[1:]],
            cwd=tmp_path,
            env={"PYTHONPATH": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), command
    assert tmp_path.joinpath("drive.bin").stat().st_size > 50
