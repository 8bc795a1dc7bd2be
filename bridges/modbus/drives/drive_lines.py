"""Lines of a bench to real drives: drives at one place share one."""

from bridges.modbus.drives.drive_line import DriveLine
from bridges.modbus.drives.modbus_drive_address import RtuPlace, TcpPlace
from hil.drives.real_drive import RealDrive


class DriveLines:
    """Lines by place. One is open while a drive is at its place."""

    def __init__(self) -> None:
        self._lines: dict[str, DriveLine] = {}

    def join(self, member: RealDrive, place: TcpPlace | RtuPlace, timeout_s: float) -> DriveLine:
        """Give a drive its line. The longest of the drives' times for an answer holds for all of them."""
        line = self._lines.get(place.where)
        if line is None or line.place != place:
            line = self._lines[place.where] = DriveLine(place, timeout_s)
        line.extend_timeout(timeout_s)
        line.members.append(member)
        if line.is_open:
            member.place_found()
        return line

    async def leave(self, member: RealDrive, line: DriveLine) -> None:
        """Take a drive off its line; the last one closes it."""
        if member in line.members:
            line.members.remove(member)
        if not line.members:
            if self._lines.get(line.place.where) is line:
                del self._lines[line.place.where]
            await line.close()
