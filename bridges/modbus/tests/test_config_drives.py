"""Real Modbus drives in a configuration: where they are, and their maps."""

from pathlib import Path

import pytest

from bridges.modbus.drives.modbus_drive_address import (
    ModbusDriveAddress,
    RtuPlace,
    TcpPlace,
    modbus_drive_address,
)
from hil.compose import find_catalogue
from hil.config import BenchConfig, ConfigError, diff, parse
from hil.wire.address_keys import AddressRefused

CATALOGUE = find_catalogue()
MAP = """\
modbus_map: 1
position_deg: {input: 0, type: i32, scale: 0.01}
set_point_deg: {holding: 10, type: i32, scale: 0.01}
control: {enable: {holding: 20, bit: 0}, start: {holding: 20, bit: 1}}
"""
TCP, RTU = "modbus+tcp://10.0.0.5:502?unit=1", "modbus+rtu:///dev/ttyUSB0?baud=9600&format=8N1&unit=3"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "lathe.yaml").write_text(MAP)
    return tmp_path


def read(folder: Path, *lines: str) -> BenchConfig:
    text = "\n".join(["bench: t", "devices:", *(f"  {line}" for line in lines)])
    return parse(text, str(folder / "b.yaml"), CATALOGUE)


def problems(folder: Path, *lines: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        read(folder, *lines)
    return [
        f"{Path(p.file).name}:{p.line}:{p.column}: {p.message} ({p.remedy})" for p in caught.value.problems
    ]


def drive(at: str, rest: str = ", map: lathe.yaml") -> str:
    return f'{{profile: modbus_drive, at: "{at}"{rest}}}'


def test_drives_of_a_bench(folder: Path) -> None:
    config = read(
        folder,
        f"x: {drive(TCP)}",
        f"y: {drive(RTU, ', map: lathe.yaml, poll_interval_ms: 5, setpoint_rate_Hz: 100')}",
        f"z: {drive(RTU.replace('unit=3', 'unit=4'))}",
        "w: {profile: modbus_drive}",
    )
    addresses = {name: modbus_drive_address(str(device.at)) for name, device in config.real.items()}
    assert addresses["x"] == ModbusDriveAddress(TcpPlace("10.0.0.5", 502), 1)
    assert addresses["y"] == ModbusDriveAddress(RtuPlace("/dev/ttyUSB0", 9600, "8N1"), 3)
    assert list(config.real) == ["x", "y", "z"]
    assert list(config.twins) == ["w"]
    found = CATALOGUE.own_map(config.devices["x"], CATALOGUE.profiles["modbus_drive"])
    assert found is not None
    assert list(found.control) == ["enable", "start"]


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ("modbus+udp://x:502?unit=1", "there is no scheme 'modbus+udp' (write modbus+tcp://"),
        ("modbus://x:502?unit=1", "there is no scheme 'modbus' (write modbus+tcp://"),
        ("modbus+tcp:x", "there is no scheme 'modbus+tcp:x' (write modbus+tcp://"),
        ("modbus+tcp://x:502", "no unit is given (write modbus+tcp://x:502?unit=1)"),
        (
            "modbus+rtu:///dev/ttyUSB0?baud=9600",
            "no unit is given (write modbus+rtu:///dev/ttyUSB0?baud=9600&un",
        ),
        (
            "modbus+tcp://x:502?unit=0",
            "'0' is for all units at once, and nobody answers (write 1 to 247, or 255",
        ),
        (
            "modbus+tcp://x:502?unit=248",
            "'248' is no unit (write 1 to 247, or 255 for a device that is no gate",
        ),
        ("modbus+rtu:///dev/x?unit=255", "'255' is no unit (write 1 to 247)"),
        ("modbus+tcp://x:502?unit=one", "'one' is no unit"),
        ("modbus+tcp://x:502?unit=", "'' is no unit"),
        ("modbus+tcp://x:502?unit=1&unit=2", "unit is there twice (leave one of them out)"),
        ("modbus+tcp://x:502?unit=1&baud=9600", "there is no 'baud' in this address (known are: unit)"),
        (
            "modbus+rtu:///dev/x?unit=1&speed=9600",
            "there is no 'speed' in this address (known are: unit, baud, f",
        ),
        ("modbus+tcp://x:502?unit", "the part after ? is not of the form key=value"),
        ("modbus+rtu:///dev/x?unit=1&baud=fast", "'fast' is no speed (write 300 to 4000000)"),
        ("modbus+rtu:///dev/x?unit=1&baud=110", "'110' is no speed"),
        ("modbus+rtu:///dev/x?unit=1&format=7E1", "'7E1' is no format of a character (known are: 8E1, 8O1"),
        ("modbus+rtu://dev/ttyUSB0?unit=1", "there is no path of a serial port (write three slashes"),
        ("modbus+tcp://:502?unit=1", "there is no host, or more than host and port"),
        ("modbus+tcp://x:0?unit=1", "'0' is no port (write 1 to 65535, most often 502)"),
        ("modbus+tcp://x:99999?unit=1", "'99999' is no port"),
        ("modbus+tcp://x/y?unit=1", "there is no host, or more than host and port"),
        ("modbus+tcp://[::1?unit=1", "there is no host, or more than host and port"),
        ("modbus+tcp://x:502?unit=1#2", "'1#2' is no unit"),
        ("modbus+tcp://me@x:502?unit=1", "there is no host, or more than host and port"),
        ("/dev/ttyUSB0", "a real modbus_drive is reached over Modbus (write modbus+tcp://"),
    ],
)
def test_an_address_that_cannot_be(folder: Path, at: str, said: str) -> None:
    (problem,) = problems(folder, f"x: {drive(at)}")
    assert problem.startswith(f"b.yaml:3:34: devices.x.at: {said}")


@pytest.mark.parametrize(
    ("rest", "said"),
    [
        ("", "devices.x.map: a real drive has registers of its own, and there is no map (add the line"),
        (", map: gone.yaml", "devices.x.map: "),
        (", map: lathe.yaml, port: pty", "devices.x.port: a real drive has no such key"),
        (", map: lathe.yaml, baud: 9600", "devices.x.baud: a real drive has no such key"),
        (", map: lathe.yaml, plant: full", "devices.x.plant: a real drive has no such key"),
        (", map: lathe.yaml, poll_interval_ms: 0", "devices.x.poll_interval_ms: the number 0 is too small"),
        (", map: lathe.yaml, poll_ms: 5", "devices.x.poll_ms: unknown key"),
    ],
)
def test_keys_that_a_real_drive_needs_or_has_not(folder: Path, rest: str, said: str) -> None:
    found = problems(folder, f"x: {drive(TCP, rest)}")
    assert len(found) == 1
    assert found[0].partition(": ")[2].startswith(said)


def test_what_is_no_drive_has_no_such_address_and_no_polls(folder: Path) -> None:
    (said,) = problems(folder, f's1: {{profile: sac, at: "{TCP}"}}')
    assert said.startswith("b.yaml:3:26: devices.s1.at: a sac is no Modbus drive (")
    (said,) = problems(folder, "s1: {profile: sac, at: /dev/ttyUSB0, poll_interval_ms: 5}")
    assert "devices.s1.poll_interval_ms: only a drive on Modbus or CAN is polled" in said
    (said,) = problems(folder, "m1: {profile: mechaduino, poll_interval_ms: 5}")
    assert "devices.m1.poll_interval_ms: a twin tells its state without being asked" in said


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (drive(RTU), "device x has unit 3 there already (each drive on a line has a unit of its own)"),
        (
            drive(RTU.replace("unit=3", "unit=4").replace("9600", "19200")),
            "device x has this line: /dev/ttyUSB0 at 9600 baud, 8N1 (a line has one speed and one format",
        ),
        ("{profile: sac, at: /dev/ttyUSB0}", "device x is there (each board has its own port)"),
    ],
)
def test_two_at_one_place(folder: Path, other: str, said: str) -> None:
    (problem,) = problems(folder, f"x: {drive(RTU)}", f"y: {other}")
    assert problem.startswith("b.yaml:4:")
    assert f"devices.y.at: {said}" in problem
    read(folder, f"x: {drive(TCP)}", f"y: {drive(TCP.replace('unit=1', 'unit=2'))}")
    read(folder, f"x: {drive(TCP)}", f"y: {drive(TCP.replace('502', '503'))}")


def test_mistakes_in_a_map_have_the_maps_lines(folder: Path) -> None:
    (folder / "lathe.yaml").write_text(MAP.replace("holding: 10", "holding: 20"))
    found = problems(folder, f"x: {drive(TCP)}")
    assert any(each.startswith("lathe.yaml:4:") for each in found), found
    assert any("devices.x.map" in each for each in found)


def test_a_fault_of_a_line_cannot_be_on_a_drive(folder: Path) -> None:
    text = f"bench: t\ndevices:\n  x: {drive(TCP)}\nfaults:\n- {{fault: byte_drop, target: x, rate: 0.1}}"
    with pytest.raises(ConfigError, match='byte_drop cannot be on "x"'):
        parse(text, str(folder / "b.yaml"), CATALOGUE)


def test_a_map_that_has_changed_restarts_its_drive(folder: Path) -> None:
    before = read(folder, f"x: {drive(TCP)}", f"y: {drive(RTU)}")
    (folder / "mill.yaml").write_text(MAP.replace("0.01", "0.1"))
    after = read(folder, f"x: {drive(TCP, ', map: mill.yaml')}", f"y: {drive(RTU)}")
    changes = {change.device: change.action for change in diff(before, after)}
    assert changes == {"x": "restart", "y": "keep"}


@pytest.mark.parametrize(("said", "echo"), [("", None), ("&echo=true", True), ("&echo=false", False)])
def test_the_echo_of_a_line_is_a_part_of_the_address(said: str, echo: bool | None) -> None:
    place = modbus_drive_address(f"modbus+rtu:///dev/ttyUSB0?unit=1{said}").place
    assert isinstance(place, RtuPlace)
    assert place.echo is echo
    with pytest.raises(AddressRefused, match="'maybe' is no echo"):
        modbus_drive_address("modbus+rtu:///dev/ttyUSB0?unit=1&echo=maybe")
