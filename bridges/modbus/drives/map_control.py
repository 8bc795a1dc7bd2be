"""Verbs of a real drive with a map of version 2: commands by value, blocks, speeds without an angle."""

from collections.abc import Mapping
from types import MappingProxyType

from bridges.modbus.drives.map_orders import MapOrders, Writes
from bridges.modbus.drives.register_control import RegisterControl
from bridges.modbus.drives.register_drive import RegisterDrive
from bridges.modbus.drives.register_motion import RegisterMotion, ramps_of
from hil.drives.drive_link import IN_TURN, URGENT
from hil.vocab.axis import How
from hil.vocab.verbs import VerbRefused

NO_ANGLE = "this drive only turns: its map has no set_point_deg and no moves; use run"


class MapMotion(RegisterMotion):
    """Motion of one drive by its own ramps."""

    def __init__(self, drive: RegisterDrive) -> None:
        super().__init__(drive)
        self.orders = MapOrders(drive.map, drive.cell)

    def check(self, *angles_deg: float) -> None:
        if not self._drive.has_angle:
            raise VerbRefused("cannot", NO_ANGLE)
        for angle_deg in angles_deg:
            self._order("start_absolute", {"set_point_deg": angle_deg})

    def _order(self, word: str, values: Mapping[str, float]) -> list[Writes]:
        """Writes of a command. Raises VerbRefused: the map has none, or no register for a value."""
        try:
            steps = self.orders.order(word, values)
        except ValueError as error:
            raise VerbRefused("bad_parameter", str(error)) from None
        if steps is None:
            raise VerbRefused("cannot", f"the map has no command for {word.partition('_')[0]}")
        return steps

    async def tell(
        self, word: str, values: Mapping[str, float] = MappingProxyType({}), order: int = IN_TURN
    ) -> None:
        """Tell the drive a command. Raises ``ASKING``, VerbRefused."""
        session = self._drive.link.session
        for writes in self._order(word, values):
            await self._drive.write_all(writes, session, order)

    async def _send(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
        session: int,
    ) -> None:
        if "start" in self._drive.map.control:
            await super()._send(position_deg, velocity_rpm, acceleration_rpm_per_s, start_ns, session)
            return
        values = ramps_of(velocity_rpm, acceleration_rpm_per_s) | {"set_point_deg": position_deg}
        for writes in self._order("start_absolute", values):
            await self._drive.write_all(writes, session)
        self._await_end(position_deg)
        self._begins_ns = None

    async def run(self, velocity_rpm: float | None, acceleration_rpm_per_s: float | None) -> None:
        """Let the drive turn. Raises ``ASKING``, VerbRefused."""
        self.abandon()
        values: dict[str, float] = {}
        if velocity_rpm is not None:
            is_signed = "run_velocity_rpm" in self._drive.map.values
            name = "run_velocity_rpm" if is_signed else "set_velocity_rpm"
            values[name] = velocity_rpm if is_signed else abs(velocity_rpm)
            values["reverse"] = float(velocity_rpm < 0 and not is_signed)
        if acceleration_rpm_per_s is not None:
            values["acceleration_rpm_per_s"] = acceleration_rpm_per_s
        await self.tell("run", values)

    async def stop(self, how: How = "grace", acceleration_rpm_per_s: float | None = None) -> None:
        if "stop" in self._drive.map.control or not self.orders.knows("stop"):
            await super().stop(how, acceleration_rpm_per_s)
            return
        self.abandon()
        word = "halt" if how == "prejudice" and self.orders.knows("halt") else "stop"
        await self.tell(word, order=URGENT)

    async def reset(self) -> None:
        if "reset" in self._drive.map.control:
            await super().reset()
            return
        self.abandon()
        await self.tell("reset", order=URGENT)


class MapControl(RegisterControl):
    """Control of one drive with a map of version 2."""

    motion_type = MapMotion
    _motion_of: MapMotion

    @property
    def has_own_ramps(self) -> bool:
        of = self._registers.map
        return "start" in of.control or self._motion_of.orders.knows("start_absolute")

    async def _move_abs(
        self,
        position_deg: float,
        velocity_rpm: float | None = None,
        acceleration_rpm_per_s: float | None = None,
    ) -> dict[str, float]:
        self.motion.check(position_deg)
        return await super()._move_abs(position_deg, velocity_rpm, acceleration_rpm_per_s)

    async def _move_rel(self, angle_deg: float, **ramps: float) -> dict[str, float]:
        self.motion.check()
        return await super()._move_rel(angle_deg, **ramps)

    async def _run(
        self, velocity_rpm: float | None = None, acceleration_rpm_per_s: float | None = None
    ) -> dict[str, float]:
        if self.drive.fault:
            raise VerbRefused("not_now", f"{self.drive.fault}; clear it first")
        await self._motion_of.run(velocity_rpm, acceleration_rpm_per_s)
        return {}

    async def _enable(self) -> dict[str, float]:
        return await self._switch("enable", is_on=True)

    async def _disable(self) -> dict[str, float]:
        return await self._switch("disable", is_on=False)

    async def _switch(self, word: str, *, is_on: bool) -> dict[str, float]:
        """Switch its loop by a command, where it has one; a drive without one is on while it moves."""
        drive = self._registers
        if "enable" in drive.map.control:
            return await (super()._enable() if is_on else super()._disable())
        self.motion.abandon()
        if not self._motion_of.orders.knows(word):
            if not is_on and self._motion_of.orders.knows("stop"):
                await self._motion_of.tell("stop", order=URGENT)
            drive.note_told(enable=is_on)
            return {}
        await self._motion_of.tell(word, order=URGENT)
        drive.note_told(enable=is_on)
        if drive.tells_enabled:
            await self._until(lambda: drive.is_on == is_on, f"{word}d")
        return {}
