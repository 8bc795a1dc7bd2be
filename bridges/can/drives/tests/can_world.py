"""Real CANopen drives of a bench without the bench."""

from drive_world import DriveWorld

from bridges.can.drives.can_control import CanControl
from bridges.can.drives.can_drive import CanDrive, CanSpec
from bridges.can.drives.can_drive_address import CanDriveAddress, CanPlace
from hil.drives.drive_control import DriveControl
from hil.drives.real_drive import DrivePace


class CanWorld(DriveWorld):
    """CANopen drives, by name."""

    def add_can(
        self, name: str, place: CanPlace, node: int, master: int | None = None, timeout_s: float = 0.2
    ) -> DriveControl:
        spec = CanSpec(name, CanDriveAddress(place, node, master), DrivePace(0.01, timeout_s, 0.01))
        return self.begin(name, CanControl(CanDrive(spec, lambda: self.now_ns)))
