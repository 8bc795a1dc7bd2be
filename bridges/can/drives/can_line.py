"""CAN bus with real drives: opened, and opened again with growing waits, its frames handed to the drives by
their nodes, and a SYNC for those that want one."""

import asyncio
import logging
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import Protocol

from bridges.can.canopen.can_ids import EMCY, ERROR_CONTROL, SDO_ANSWER, SYNC, TPDO
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.master.node_watch import HEARTBEAT_NS
from bridges.can.drives.can_adapter import Beat, CanAdapter
from bridges.can.drives.can_drive_address import CanPlace
from bridges.can.frames.can_frame import CanFrame
from hil.drives.drive_link import PlaceLost, Waits

_FUNCTION, _NODE = 0x780, 0x7F

log = logging.getLogger("hil")


class BusDrive(Protocol):
    """Drive on a bus."""

    node: int
    master: int | None
    """Node as which the daemon tells it its heartbeat."""

    @property
    def wants_sync(self) -> bool:
        """True while its process data come with SYNC."""

    def place_found(self) -> None:
        """Note that the bus can be reached."""

    def place_lost(self, why: str) -> None:
        """Note that it cannot."""

    def before_sync(self) -> Iterable[CanFrame]:
        """Frames that it takes with the SYNC that comes now; in the thread that sends them."""

    def hear_answer(self, data: bytes) -> None:
        """Take an answer of its SDO server."""

    def hear_process_data(self, number: int, data: bytes) -> None:
        """Take a TPDO, the first is 0."""

    def hear_error_control(self, data: bytes) -> None:
        """Take a heartbeat, a boot-up, or an answer to guarding."""

    def hear_emergency(self, data: bytes) -> None:
        """Take an emergency message."""


class CanLine:
    """Bus at one place. ``sync_ns``: period of SYNC."""

    def __init__(self, place: CanPlace, sync_ns: int) -> None:
        self.place, self.sync_ns = place, sync_ns
        self.members: dict[int, BusDrive] = {}
        self.is_open = False
        self._why = f"{place}: it is not open yet"
        self._waits = Waits()
        self._gone = asyncio.Event()
        self._is_closed = self._is_used = False
        self._lives_s = 0.0
        beat = Beat(sync_ns / 1e9, self._beat)
        self._adapter = CanAdapter(place, self._hear, self._lost, beat)
        self._task = asyncio.get_running_loop().create_task(self._run())

    async def close(self) -> None:
        """Close the bus."""
        self._is_closed = True
        self._task.cancel()
        with suppress(asyncio.CancelledError):
            await self._task
        await self._adapter.close()
        self._lost(f"{self.place}: the bus is closed")

    def send(self, identifier: int, data: bytes = b"") -> None:
        """Send a data frame. Raises PlaceLost."""
        self._send(CanFrame(identifier, data))

    def ask_remotely(self, identifier: int, count: int) -> None:
        """Send a remote frame that asks for so many bytes. Raises PlaceLost."""
        self._send(CanFrame(identifier, is_remote=True, remote_dlc=count))

    def _send(self, frame: CanFrame) -> None:
        if not self.is_open:
            raise PlaceLost(self._why)
        self._adapter.send(frame)

    async def _run(self) -> None:
        while not self._is_closed:
            try:
                await self._adapter.open()
                self._gone.clear()
                self.is_open = True
                for member in list(self.members.values()):
                    member.place_found()
                await self._gone.wait()
            except PlaceLost as error:
                self._lost(str(error))
            except Exception as error:  # hil's own error: this bus stands still for a while, others go on
                self._lost(f"{self.place}: an error of hil, see its log: {error!r}")
                log.exception("the bus %s", self.place)
            await self._adapter.close()
            # An adapter that opens and is lost before it was of use is not tried any sooner.
            if self._is_used:
                self._waits.reset()
            self._is_used = False
            await asyncio.sleep(self._waits.take_ns() / 1e9)

    def _beat(self) -> list[CanFrame]:
        """Frames of one beat: set-points, and a SYNC while somebody wants one; the master's heartbeat."""
        # A copy: this is in the thread that sends, while drives come and go.
        members = [member for member in list(self.members.values()) if member.wants_sync]
        frames = [frame for member in members for frame in member.before_sync()]
        if members:
            self._is_used = True
            frames.append(CanFrame(SYNC))
        return frames + self._life()

    def _life(self) -> list[CanFrame]:
        """Heartbeat of the master that drives watch, if it is due."""
        now_s = time.monotonic()
        if now_s < self._lives_s:
            return []
        self._lives_s = now_s + HEARTBEAT_NS / 1e9
        masters = {member.master for member in list(self.members.values()) if member.master is not None}
        return [CanFrame(ERROR_CONTROL + master, bytes([NmtState.OPERATIONAL])) for master in masters]

    def _lost(self, why: str) -> None:
        self.is_open, self._why = False, why
        self._gone.set()
        for member in list(self.members.values()):
            member.place_lost(why)

    def _hear(self, frame: CanFrame) -> None:
        member = self.members.get(frame.id & _NODE)
        if member is None or frame.is_extended or frame.is_remote:
            return
        function = frame.id & _FUNCTION
        if function in TPDO:
            member.hear_process_data(TPDO.index(function), frame.data)
        elif function == SDO_ANSWER:
            member.hear_answer(frame.data)
        elif function == ERROR_CONTROL:
            member.hear_error_control(frame.data)
        elif function == EMCY:
            member.hear_emergency(frame.data)


class CanLines:
    """Buses of a bench by place. One is open while a drive is on it."""

    def __init__(self) -> None:
        self._lines: dict[str, CanLine] = {}

    def join(self, member: BusDrive, place: CanPlace, sync_ns: int) -> CanLine:
        """Give a drive its bus; its SYNC is that of the first who came."""
        line = self._lines.get(place.where)
        if line is None or line.place != place:
            line = self._lines[place.where] = CanLine(place, sync_ns)
        line.members[member.node] = member
        if line.is_open:
            member.place_found()
        return line

    async def leave(self, member: BusDrive, line: CanLine) -> None:
        """Take a drive off its bus; the last one closes it."""
        if line.members.get(member.node) is member:
            del line.members[member.node]
        if not line.members:
            if self._lines.get(line.place.where) is line:
                del self._lines[line.place.where]
            await line.close()
