"""A device's map of registers of its own: a file or a mapping, and what is said of either."""

from collections.abc import Callable
from pathlib import Path

import pytest

from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.cells import BIT
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from hil.compose import find_catalogue
from hil.compose.simulated_config import as_simulated
from hil.config import BenchConfig, ConfigError, diff, from_dict, parse

CATALOGUE = find_catalogue()
PROFILE = CATALOGUE.profiles["modbus_drive"]
MAP = """\
modbus_map: 1
position_deg: {input: 0, type: i32}
set_point_deg: {holding: 0}
control: {enable: {coil: 0}, start: {coil: 1}}
"""
BENCH = "bench: t\ndevices:\n  x1: {profile: modbus_drive, map: drives/lathe.yaml}\n"
CANNOT = "the map drives/lathe.yaml cannot be used (mend what is said of it below)"
Read = Callable[[str], BenchConfig]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    (tmp_path / "drives").mkdir()
    (tmp_path / "drives" / "lathe.yaml").write_text(MAP)
    return lambda text: parse(text, str(tmp_path / "b.yaml"), CATALOGUE)


def problems(read: Read, text: str, folder: Path) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        read(text)
    return [str(problem).replace(f"{folder}/", "") for problem in caught.value.problems]


def test_a_file_is_looked_up_from_the_configurations_folder(read: Read) -> None:
    of = CATALOGUE.own_map(read(BENCH).devices["x1"], PROFILE)
    assert of == DriveMap(
        values={
            "position_deg": RegisterPlace(Table.INPUT_REGISTERS, 0, "i32"),
            "set_point_deg": RegisterPlace(Table.HOLDING_REGISTERS, 0),
        },
        control={"enable": RegisterPlace(Table.COILS, 0, BIT), "start": RegisterPlace(Table.COILS, 1, BIT)},
    )


def test_a_drive_without_one_has_its_profiles(read: Read) -> None:
    of = CATALOGUE.own_map(read("bench: t\ndevices: {x1: {profile: modbus_drive}}").devices["x1"], PROFILE)
    assert of is not None
    assert of.identity["product"] == "modbus_drive"
    assert set(of.parameters) == {"pKp", "pKi", "pKd"}
    other = read("bench: t\ndevices: {s1: {profile: sac, port: pty}}").devices["s1"]
    assert CATALOGUE.own_map(other, CATALOGUE.profiles["sac"]) is None


def test_a_log_has_the_map_itself(read: Read) -> None:
    config = read(BENCH)
    assert from_dict(as_simulated(config), CATALOGUE).devices["x1"].map == config.devices["x1"].map


def test_a_changed_map_starts_its_device_anew(read: Read, tmp_path: Path) -> None:
    before = read(BENCH)
    (tmp_path / "drives" / "lathe.yaml").write_text(MAP.replace("coil: 1", "coil: 7"))
    (change,) = diff(before, read(BENCH))
    assert (change.action, change.why) == ("restart", ("map.control.start.coil: 1 -> 7",))


def test_what_is_wrong_in_a_file_is_said_with_its_name_and_place(read: Read, tmp_path: Path) -> None:
    (tmp_path / "drives" / "lathe.yaml").write_text(MAP.replace("coil: 1", "coil: 0").replace("i32", "i8"))
    two = f"{BENCH}  x2: {{profile: modbus_drive, map: drives/lathe.yaml}}\n"
    assert problems(read, two, tmp_path) == [
        f"b.yaml:3:36: devices.x1.map: {CANNOT}",
        f"b.yaml:4:36: devices.x2.map: {CANNOT}",
        'drives/lathe.yaml:2:32: position_deg.type: "i8" is none of the choices'
        " (write 'u16', 'i16', 'u32', 'i32', 'f32', 'u48', 'i48', 'u64', 'i64', 'f64' or 'text')",
        "drives/lathe.yaml:4:44: control.start.coil: coil 0 is control.enable (line 4)"
        " (write one that is free)",
    ]


@pytest.mark.parametrize(
    ("device", "problem"),
    [
        (
            "{profile: modbus_drive, map: none.yaml}",
            "3:36: devices.x1.map: none.yaml cannot be read: No such file or directory"
            " (write where it is, from this file on)",
        ),
        (
            "{profile: modbus_drive, map: drives}",
            "3:36: devices.x1.map: drives cannot be read: Is a directory"
            " (write where it is, from this file on)",
        ),
        (
            "{profile: modbus_drive, map: 7}",
            "3:36: devices.x1.map: a file's path or a map is wanted here, not the number 7"
            " (write the path, as in lathe.yaml)",
        ),
        (
            "{profile: modbus_drive, map: ~/x}",
            '3:36: devices.x1.map: a file\'s path or a map is wanted here, not "~/x"'
            " (write the path, as in lathe.yaml)",
        ),
        (
            "{profile: sac, port: pty, map: drives/lathe.yaml}",
            "3:33: devices.x1.map: a sac has no map of its own, but one of its verbs and fields"
            " (leave this key out)",
        ),
    ],
)
def test_what_is_no_map(read: Read, tmp_path: Path, device: str, problem: str) -> None:
    found = problems(read, f"bench: t\ndevices:\n  x1: {device}\n", tmp_path)
    assert found == [f"b.yaml:{problem}"]


def test_what_is_no_text_is_said_so(read: Read, tmp_path: Path) -> None:
    (tmp_path / "drives" / "lathe.yaml").write_bytes("# Dreh\nbänk: ".encode() + b"\xff\xfe")
    (first, second) = problems(read, BENCH, tmp_path)
    assert first.startswith("b.yaml:3:36: devices.x1.map: the map drives/lathe.yaml cannot be used")
    assert second.startswith(
        "drives/lathe.yaml:2:7: the byte 0xff is not UTF-8 text (save the file as UTF-8)"
    )


def test_a_map_that_is_written_out_has_its_faults_where_they_stand(read: Read, tmp_path: Path) -> None:
    indented = MAP.replace("\n", "\n      ").replace("holding: 0", "holding: 0, bit: 1")
    text = f"bench: t\ndevices:\n  x1:\n    profile: modbus_drive\n    map:\n      {indented}\n"
    text += "      parameters: {pKq: {holding: 9}, pKp: {holding: 8, scale: .nan}}\n"
    found = problems(read, text, tmp_path)
    assert [line.partition(" (")[0] for line in found] == [
        "b.yaml:8:35: devices.x1.map.set_point_deg.bit: set_point_deg is a value and no bit",
        'b.yaml:11:20: devices.x1.map.parameters.pKq: there is no parameter "pKq"',
        "b.yaml:11:64: devices.x1.map.parameters.pKp.scale: nan is not a number to compute with",
    ]
