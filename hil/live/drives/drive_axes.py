"""Real drives of a bench, by their devices' names, and as runs find them."""

from collections.abc import Mapping
from dataclasses import replace

from hil.live.configured import Configured
from hil.live.drives.drive_control import DriveControl
from hil.live.drives.shared_lines import SharedLines
from hil.vocab.axis import Axis, AxisNow


class Drives(dict[str, DriveControl]):
    """Drives by name. Only ``hil.live.apply`` changes them."""

    def __init__(self) -> None:
        super().__init__()
        self._lines = SharedLines()

    def begin(self, name: str) -> None:
        """Begin to ask a drive."""
        self[name].begin(self._lines)

    async def end(self, control: DriveControl) -> None:
        """Stop a drive that moves, and ask it no more."""
        await control.axis.end()
        await control.end(self._lines)

    async def close(self) -> None:
        """Stop all that move, and ask nobody any more."""
        while self:
            await self.end(self.popitem()[1])


class DriveAxes:
    """Axes of the drives of a bench."""

    def __init__(self, drives: Mapping[str, DriveControl], configured: Configured) -> None:
        self._drives = drives
        self._configured = configured

    def __contains__(self, name: str) -> bool:
        return name in self._drives

    def axes(self) -> dict[str, AxisNow]:
        found = {name: control.axis.now() for name, control in self._drives.items()}
        if (speed := self._configured.config.speed) != 1:
            why = f"the bench goes at {speed:g} times the speed of its real drives"
            return {
                name: replace(now, why_not=why, remedy="write `speed: 1` in its configuration")
                for name, now in found.items()
            }
        return found

    def __getitem__(self, name: str) -> Axis:
        return self._drives[name].axis
