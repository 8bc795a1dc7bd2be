"""Real drive that the configuration asks for."""

from collections.abc import Callable

from hil.config import Catalogue, DeviceConfig
from hil.drives.drive_control import DriveControl
from hil.drives.real_drive import DrivePace

ANSWER_S = 0.2
"""Time for a real drive to answer, beside the delay of its line: a request and its answer take 0.1 s at 9600
baud, if they are long."""


def make_drive(
    name: str, device: DeviceConfig, catalogue: Catalogue, now_ns: Callable[[], int]
) -> DriveControl | None:
    """Make a real drive; None: the device is another real board."""
    profile = catalogue.profiles[device.profile]
    if (kind := catalogue.drive_kind(profile)) is None:
        return None
    pace = DrivePace(
        interval_s=device.poll_interval_ms / 1e3,
        timeout_s=ANSWER_S + device.line_delay_ms / 1e3,
        setpoint_s=1 / device.setpoint_rate_Hz,
    )
    own_map = catalogue.own_map(device, profile)
    made: DriveControl = kind.make(name, kind.address(str(device.at)), device, own_map, pace, now_ns)
    return made
