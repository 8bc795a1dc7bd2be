"""EDS files against the rules of CiA 306, and against the tools of Lely's masters (``dcf-tools``)."""

import subprocess
import sys
from configparser import RawConfigParser
from pathlib import Path

import pytest
import yaml
from canopen_rig import ENTRIES, IDENTITY, NODE, Rig

from bridges.can.canopen.node.communication_entries import Identity
from bridges.can.canopen.node.eds import eds_text

TOOLS = Path(sys.executable).parent
GONE = """
from importlib import import_module
from pathlib import Path
def resource_filename(name, file):
    return str(Path(import_module(name).__file__).parent / file)
"""
"""What the tools use of ``pkg_resources``, which newer setuptools have no more."""
MOST_IN_LINE = 255
TYPES = {*range(0x01, 0x0E), 0x0F, 0x10, 0x11, *range(0x12, 0x17), *range(0x18, 0x1C)}
OBJECT_TYPES = {"0x2", "0x7", "0x8", "0x9"}
ACCESS = {"ro", "wo", "rw", "rwr", "rww", "const"}
MANDATORY = {
    "FileInfo": ("FileName", "FileVersion", "FileRevision", "EDSVersion"),
    "DeviceInfo": ("VendorName", "VendorNumber", "ProductName", "Granularity", "NrOfRXPDO", "NrOfTXPDO"),
    "DummyUsage": ("Dummy0001", "Dummy0007"),
    "MandatoryObjects": ("SupportedObjects",),
    "OptionalObjects": ("SupportedObjects",),
    "ManufacturerObjects": ("SupportedObjects",),
}


@pytest.fixture
def text() -> str:
    return eds_text(Rig().node.dictionary, IDENTITY, "stub.eds")


def parsed(text: str) -> RawConfigParser:
    """Parse strictly: no section and no key twice, no interpolation, keys as they are."""
    parser = RawConfigParser(delimiters=("=",), comment_prefixes=(";",), strict=True)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read_string(text)
    return parser


def objects_in(file: RawConfigParser) -> list[int]:
    found = []
    for group in ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"):
        count = int(file[group]["SupportedObjects"])
        assert list(file[group])[1:] == [str(at) for at in range(1, count + 1)]
        found += [int(file[group][str(at)], 16) for at in range(1, count + 1)]
    return found


def test_rules_of_the_standard(text: str) -> None:
    file = parsed(text)
    assert all(len(line) <= MOST_IN_LINE and line.isascii() for line in text.splitlines())
    for section, keys in MANDATORY.items():
        assert set(keys) <= set(file[section]), section
    indexes = objects_in(file)
    assert len(indexes) == len(set(indexes))
    sections = set(file.sections()) - {*MANDATORY, "Comments"}
    for index in indexes:
        name = f"{index:04X}"
        sections.remove(name)
        if "SubNumber" not in file[name]:
            check_variable(dict(file[name]))
            continue
        subs = [section for section in sections if section.startswith(f"{name}sub")]
        assert len(subs) == int(file[name]["SubNumber"])
        assert file[name]["ObjectType"] in ("0x8", "0x9")
        highest = max(int(section.partition("sub")[2], 16) for section in subs)
        if file[f"{name}sub0"]["AccessType"] == "const":
            assert int(file[f"{name}sub0"]["DefaultValue"]) == highest
        for section in subs:
            check_variable(dict(file[section]))
            sections.remove(section)
    assert sections == set()


def check_variable(values: dict[str, str]) -> None:
    assert 0 < len(values["ParameterName"]) <= 241
    assert values["ObjectType"] in OBJECT_TYPES
    assert int(values["DataType"], 16) in TYPES
    assert values["AccessType"] in ACCESS
    assert values["PDOMapping"] in ("0", "1")
    low, high = (values.get(limit) for limit in ("LowLimit", "HighLimit"))
    if low is not None and high is not None:
        assert int(low, 0) <= int(values["DefaultValue"], 0) <= int(high, 0)


def test_it_is_the_same_for_each_id_and_each_time(text: str) -> None:
    rig = Rig(node_id=99)
    rig.node.set_value(0x2003, 0, 5)
    assert eds_text(rig.node.dictionary, IDENTITY, "stub.eds") == text
    assert "DefaultValue=$NODEID+0x200\n" in text


def test_names_cannot_break_it() -> None:
    identity = Identity(1, 2, 3, 4, "a\nb]é=;", vendor_name="")
    rig = Rig(identity=identity)
    file = parsed(eds_text(rig.node.dictionary, identity, "x.eds"))
    assert file["DeviceInfo"]["ProductName"] == "a?b]?=;"
    assert len(objects_in(file)) > len({entry.index for entry in ENTRIES}) + 30


def test_the_tools_of_another_master_take_it(text: str, tmp_path: Path) -> None:
    (tmp_path / "stub.eds").write_text(text)
    mapping = [{"index": 0x2009, "sub_index": 0}, {"index": 0x2002, "sub_index": 1}]
    of_node = {
        "dcf": "stub.eds",
        "node_id": NODE,
        "heartbeat_producer": 500,
        "tpdo": {2: {"enabled": True, "transmission": 1, "mapping": mapping}},
        "rpdo": {2: {"enabled": True, "transmission": 1, "mapping": mapping}},
    }
    bus = {"master": {"node_id": 1, "sync_period": 10_000}, "stub": of_node}
    (tmp_path / "bus.yml").write_text(yaml.safe_dump(bus))
    (tmp_path / "pkg_resources.py").write_text(GONE)
    for command in (["dcfchk", "-n", str(NODE), "stub.eds"], ["dcfgen", "-r", "bus.yml"]):
        done = subprocess.run(
            [TOOLS / command[0], *command[1:]],
            cwd=tmp_path,
            env={"PYTHONPATH": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, "")
    downloads = concise(tmp_path.joinpath("stub.bin").read_bytes())
    rig = Rig()
    assert len(downloads) > 10
    for index, subindex, data in downloads:
        assert rig.download(index, subindex, data) == 0, f"{index:04X}h:{subindex}"
    rig.hear("000#0105")
    assert rig.hear("080#") == ["285#0000000000"]


def concise(data: bytes) -> list[tuple[int, int, bytes]]:
    """Values of a concise DCF (CiA 302-3): what such a master writes when the node boots."""
    found, at = [], 4
    while at < len(data):
        index, subindex = int.from_bytes(data[at : at + 2], "little"), data[at + 2]
        size = int.from_bytes(data[at + 3 : at + 7], "little")
        found.append((index, subindex, data[at + 7 : at + 7 + size]))
        at += 7 + size
    assert len(found) == int.from_bytes(data[:4], "little")
    return found
