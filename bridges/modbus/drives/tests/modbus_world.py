"""Real Modbus drives of a bench without the bench."""

from drive_world import DriveWorld
from foreign_drives import drive_map

from bridges.modbus.drives.modbus_drive_address import modbus_drive_address
from bridges.modbus.drives.register_control import RegisterControl
from bridges.modbus.drives.register_drive import RegisterDrive, RegisterSpec
from bridges.modbus.registers.drive_map import DriveMap
from hil.drives.drive_control import DriveControl
from hil.drives.real_drive import DrivePace


class ModbusWorld(DriveWorld):
    """Modbus drives, by name."""

    def add(self, name: str, at: str, *, map: DriveMap | None = None, timeout_s: float = 0.2) -> DriveControl:
        pace = DrivePace(0.01, timeout_s, 0.02)
        spec = RegisterSpec(name, modbus_drive_address(at), map or drive_map(), pace)
        return self.begin(name, RegisterControl(RegisterDrive(spec, lambda: self.now_ns)))
