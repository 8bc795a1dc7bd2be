"""Real drive that the configuration asks for."""

from collections.abc import Callable

from hil.config import DeviceConfig, ProfileInfo
from hil.drives.drive_control import DriveControl
from hil.drives.real_drive import DrivePace

ANSWER_S = 0.2
"""Time for a real drive to answer, beside the delay of its line: a request and its answer take 0.1 s at 9600
baud, if they are long."""


def make_drive(
    name: str, device: DeviceConfig, profile: ProfileInfo, now_ns: Callable[[], int]
) -> DriveControl | None:
    """Make a real drive; None: the device is another real board."""
    pace = _pace_of(device)
    if node := device.can_address:
        from bridges.can.canopen.master.drive_units import GivenUnits  # most benches have no such drive
        from bridges.can.drives.can_control import CanControl
        from bridges.can.drives.can_drive import CanDrive, CanSpec

        given = device.units.model_dump() if device.units else {}
        return CanControl(CanDrive(CanSpec(name, node, pace, GivenUnits(**given)), now_ns))
    if (address := device.drive_address) is None:
        return None
    from bridges.modbus.drives.register_control import RegisterControl
    from bridges.modbus.drives.register_drive import RegisterDrive, RegisterSpec

    drive_map = device.drive_map(profile)
    assert drive_map is not None, f"{name}: the configuration's check wants a map"
    return RegisterControl(RegisterDrive(RegisterSpec(name, address, drive_map, pace), now_ns))


def _pace_of(device: DeviceConfig) -> DrivePace:
    return DrivePace(
        interval_s=device.poll_interval_ms / 1e3,
        timeout_s=ANSWER_S + device.line_delay_ms / 1e3,
        setpoint_s=1 / device.setpoint_rate_Hz,
    )
