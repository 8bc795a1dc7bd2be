"""Real CANopen drives in a configuration: where they are, and what their numbers are."""

import pytest

from bridges.can.drives.can_drive_address import CanDriveAddress, CanPlace, can_drive_address
from hil.compose import find_catalogue
from hil.config import BenchConfig, ConfigError, diff, parse

CATALOGUE = find_catalogue()
CAN0, CAN1 = "can+socketcan://can0?node=5", "can+socketcan://can1?node=6"
SLCAN = "can+slcan:///dev/ttyACM0?bitrate=1000000&node=5"


def read(*lines: str) -> BenchConfig:
    return parse("\n".join(["bench: t", "devices:", *(f"  {line}" for line in lines)]), "b.yaml", CATALOGUE)


def problems(*lines: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        read(*lines)
    return [f"{p.line}:{p.column}: {p.message} ({p.remedy})" for p in caught.value.problems]


def drive(at: str, rest: str = "", profile: str = "canopen_drive") -> str:
    return f'{{profile: {profile}, at: "{at}"{rest}}}'


def test_drives_of_a_bench() -> None:
    config = read(
        f"x: {drive(CAN0)}",
        f"y: {drive(CAN0.replace('5', '6'), ', units: {position_per_turn: 36000}, poll_interval_ms: 5')}",
        f"z: {drive(SLCAN + '&master=127', ', setpoint_rate_Hz: 100')}",
        "w: {profile: canopen_drive}",
    )
    addresses = {name: can_drive_address(str(device.at)) for name, device in config.real.items()}
    assert addresses["x"] == CanDriveAddress(CanPlace("socketcan", "can0"), 5)
    assert addresses["z"] == CanDriveAddress(CanPlace("slcan", "/dev/ttyACM0", 1_000_000, 115_200), 5, 127)
    units = config.devices["y"].units
    assert units is not None
    assert (units.position_per_turn, units.velocity_per_rpm) == (36000, None)
    assert list(config.real) == ["x", "y", "z"]
    assert list(config.twins) == ["w"]


@pytest.mark.parametrize(
    ("device", "said"),
    [
        (drive("can+socketcan://can0?node=128"), "at: '128' is no node (write 1 to 127)"),
        (
            drive("can+tcp://x?node=1"),
            "at: there is no scheme 'can+tcp' (write can+socketcan://can0?node=5",
        ),
        (drive("/dev/ttyUSB0"), "at: a real canopen_drive is reached over CAN (write can+socketcan://"),
        (drive("modbus+tcp://x?unit=1"), "at: a real canopen_drive is reached over CAN (write"),
        (
            drive(CAN0, profile="mechaduino"),
            "at: a mechaduino is no CANopen drive (write its serial port, or",
        ),
        (drive(CAN0, profile="modbus_drive"), "at: a real modbus_drive is reached over Modbus (write"),
        (drive(CAN0, ", map: x.yaml"), "map: a CANopen drive says itself what is where (leave this key out)"),
        (drive(CAN0, ", port: pty"), "port: a real drive has no such key"),
        (drive(CAN0, ", plant: full"), "plant: a real drive has no such key"),
        (
            drive(CAN0, ", units: {position_per_turn: 0}"),
            "units.position_per_turn: the number 0 is too small",
        ),
        (drive(CAN0, ", units: {per_turn: 1}"), "units.per_turn: unknown key"),
        ("{profile: canopen_drive, units: {}}", "units: a twin says them itself (leave this key out)"),
        ("{profile: sac, at: /dev/ttyUSB0, units: {}}", "units: only a CANopen drive has units of its own"),
    ],
)
def test_what_cannot_be_has_its_place_and_its_remedy(device: str, said: str) -> None:
    (problem,) = problems(f"x: {device}")
    assert problem.startswith("3:")
    assert f"devices.x.{said}" in problem


@pytest.mark.parametrize(
    ("first", "other", "said"),
    [
        (drive(CAN0), drive(CAN0), "y.at: device x has node 5 there already (each drive on a bus has a node"),
        (
            drive(SLCAN),
            drive(SLCAN.replace("1000000", "500000").replace("node=5", "node=6")),
            "y.at: device x has this adapter: /dev/ttyACM0 at 1000000 bit/s, 115200 baud (an adapter has one",
        ),
        (drive(SLCAN), "{profile: sac, at: /dev/ttyACM0}", "y.at: device x is there (each board has its own"),
        ("{profile: sac, at: /dev/ttyACM0}", drive(SLCAN), "y.at: device x is there (each board has its own"),
        (
            drive(CAN0),
            drive(CAN0.replace("5", "6"), ", setpoint_rate_Hz: 100"),
            "y.setpoint_rate_Hz: device x is on this bus, with another setpoint_rate_Hz",
        ),
        (
            drive(CAN0 + "&master=127"),
            drive(CAN0.replace("5", "6")),
            "y.at: device x is on this bus, with another master (a bus has one master",
        ),
        (
            drive(CAN0 + "&master=6"),
            drive(CAN0.replace("5", "6") + "&master=5"),
            "y.at: device x is on this bus, with another master",
        ),
        (
            drive(CAN0 + "&master=6"),
            drive(CAN0.replace("node=5", "node=6") + "&master=7"),
            "y.at: device x is on this bus, with another master",
        ),
    ],
)
def test_two_at_one_place(first: str, other: str, said: str) -> None:
    (problem,) = problems(f"x: {first}", f"y: {other}")
    assert problem.startswith("4:")
    assert f"devices.{said}" in problem
    read(f"x: {drive(CAN0)}", f"y: {drive(CAN1, ', setpoint_rate_Hz: 100')}")


def test_what_is_changed_restarts_its_drive() -> None:
    before = read(f"x: {drive(CAN0)}", f"y: {drive(CAN1)}")
    after = read(f"x: {drive(CAN0, ', units: {velocity_per_rpm: 10}')}", f"y: {drive(CAN1)}")
    changes = {change.device: change.action for change in diff(before, after)}
    assert changes == {"x": "restart", "y": "keep"}
