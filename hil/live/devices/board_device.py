"""Real board as a device of a bench: what hil can do with it is typed at its terminal."""

import errno
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from hil.live.board_backend import BoardBackend
from hil.live.devices.board_axis import BoardAxis
from hil.live.devices.real_device import RealDevice, port_counters, port_row
from hil.live.port_link import PortLink
from hil.runs import bounds_of
from hil.sim.bench import BenchRuntime
from hil.vocab.address import no_part
from hil.vocab.axis import Axis, AxisNow
from hil.vocab.desk_protocol import DeviceInfo, Done
from hil.vocab.dialogue import DialogueError
from hil.vocab.firmware import MAIN
from hil.vocab.monitoring import HealthProblem
from hil.vocab.ports import EchoStats
from hil.vocab.profile import Profile
from hil.vocab.verbs import VerbRefused

CANNOT = "the daemon sees its terminal, not its pins, shaft or encoder; type at it with `hil monitor`"
LEAD_NS = 250_000_000
"""Time to tell a SAC its motion before a phrase: 20 ms at 38400 baud, and 32 ms of a USB adapter."""
_CLOSED_TO_SERVICES = {os.strerror(number) for number in (errno.ENOENT, errno.EACCES, errno.EPERM)}
"""Errors that a device gives in the unit's sandbox: PrivateDevices=, DevicePolicy=closed."""
_BACK = {
    os.strerror(errno.EACCES): "add the user who runs hil to the group that the device belongs to",
    os.strerror(errno.EPERM): "let the container or service that hil runs in have this device",
    os.strerror(errno.ECONNREFUSED): "start what listens there",
    os.strerror(errno.ENOTTY): "this is no serial port: correct `at:`",
    os.strerror(errno.EISDIR): "this is no serial port: correct `at:`",
    os.strerror(errno.EBUSY): "end the program that has it open",
    os.strerror(errno.EAGAIN): "end the program that has it open",  # from the lock that each program takes
    "in use by ": "end the program that has it open",
    "no serial port": "this is no serial port: correct `at:`",
}
"""Remedies by the system's words, which pyserial puts into longer sentences."""


class BoardDevice(RealDevice):
    """Real board, as ``hil.vocab.device.Device``. ``bench``: the one whose time it goes by; ``profile``: its
    kind, and what that says; ``period_ns``, ``delay_ns``: interval of set-points that are typed, and delay of
    its line."""

    def __init__(
        self,
        bench: BenchRuntime,
        link: PortLink[BoardBackend],
        profile: tuple[str, Profile],
        at: str | None,
        speed: float,
        *,
        period_ns: int,
        delay_ns: int,
    ) -> None:
        super().__init__(link.label, at, speed)
        self._bench, self._link, self._backend = bench, link, link.backend
        self.faults = link.backend
        self._kind, self._says = profile
        table = self._says.table
        verbs = {verb: each for verb, each in table.items() if verb == "type" or verb in self._says.dialogues}
        self._info = DeviceInfo(self.name, self._kind, True, verbs, {}, readers=self._says.readers)
        self._axis: BoardAxis | None = None
        if make := self._says.terminal_axis:
            self._axis = BoardAxis(bench, self._backend, make(delay_ns), period_ns, LEAD_NS + delay_ns)

    def info(self, part: str) -> DeviceInfo:
        if part:
            raise KeyError(part)
        return self._info

    def no_axis(self) -> VerbRefused | None:
        return self.refusal()

    def refusal(self) -> VerbRefused:
        return VerbRefused("cannot", f"{self.name} is a real board: {CANNOT}")

    # ---- what it can be told ----

    async def do(self, part: str, verb: str, parameters: Mapping[str, float | str]) -> Done:
        """Carry out a verb by its dialogue."""
        if (dialogue := self._says.dialogues.get(verb)) is None:
            raise VerbRefused(
                "cannot",
                f"{self.name} is a real {self._kind}: its terminal has no {verb}; do it at the board",
            )
        if self._backend.is_held:
            raise VerbRefused("not_now", f"{self.name}: a run has this board; cancel it, or wait for its end")
        try:
            if self._axis and verb == self._axis.taken_by:
                await self._axis.acquire()
            else:
                if self._axis:
                    self._axis.forget()
                await self._backend.talk(dialogue(**parameters))
        except DialogueError as error:
            raise VerbRefused("not_now", str(error)) from None
        return Done(self._bench.now_ns, {})

    async def reset(self) -> Done:
        return await self.do("", "reset", {})

    def type(self, part: str, data: bytes) -> Done:
        if part not in ("", MAIN):
            raise VerbRefused("no_device", no_part(self.name, "serial interface", part, {MAIN: None}))
        try:
            self._backend.send(data)
        except DialogueError as error:
            raise VerbRefused("not_now", str(error)) from None
        return Done(self._bench.now_ns, {})

    # ---- as an axis of runs ----

    def axes(self) -> Mapping[str, AxisNow]:
        if self._axis is None:
            why = f"a real {self._kind} has nothing for runs at its terminal"
            return {self.name: AxisNow(0.0, follows_paths=False, why_not=why, tells_position=False)}
        now = self._axis.now()
        bounds = bounds_of(self._says.table, follows_paths=now.follows_paths)
        return {self.name: self.in_time(replace(now, bounds=bounds), "boards")}

    def axis(self, part: str) -> Axis:
        if self._axis is None:
            raise KeyError(self.name)
        return self._axis

    # ---- how it does ----

    @property
    def is_there(self) -> bool:
        return self._backend.line.stats().clients > 0

    @property
    def is_talking(self) -> bool:
        return self._backend.is_busy

    @property
    def where(self) -> str:
        away = "" if self.is_there else " (away, tried again each second)"
        return f"the board at {self._backend.line.address}{away}, through {self._link.port.address}"

    def echoes(self) -> Iterator[tuple[str, EchoStats | None]]:
        yield self.name, self._backend.line.stats().echo

    def listed(self, kinds: Mapping[str, str]) -> dict[str, Any]:
        return super().listed(kinds) | port_row(self._link.port)

    def status(self) -> dict[str, Any]:
        port, at = self._link.port, self._backend.line
        client, line = port.stats(), at.stats()
        notes = [] if line.clients else [f"{at.address} is away, tried again each second"]
        if lost := line.unheard_bytes + line.dropped_bytes:
            notes.append(f"{lost} bytes for it were not sent")
        return {
            **port_counters(client),
            "dropped_bytes": client.dropped_bytes + line.dropped_bytes,
            "unheard_bytes": client.unheard_bytes + line.unheard_bytes,
            "backlog_bytes": port.backlog(),
            "overrun_bytes": 0,
            "note": "; ".join(notes) or None,
            "flash": "ok",
            "port_failure": self._link.failure,
            "snapshot": None,
            "snapshots": {},
            "board": {"connects": line.connects, "rx_bytes": line.rx_bytes, "tx_bytes": line.tx_bytes},
        }

    def problems(self, is_service: bool) -> Iterator[HealthProblem]:
        line = self._backend.line
        if away := line.stats().away:
            what = f"{line.address}: {self._backend.failure or away.partition('; ')[0]}"
            yield HealthProblem(
                "port", self.name, what, f"{_back(away, is_service)}; it is tried again each second"
            )
        if failure := self._link.failure:
            yield HealthProblem("port", self.name, failure, "restart the bench")

    # ---- its life ----

    async def begin(self) -> None:
        await self._backend.line.open(self._backend.from_board)

    def leave(self) -> None:
        """Leave nothing behind: it has no place in simulated time."""

    async def stop(self) -> None:
        if self._axis:
            await self._axis.end()

    async def close(self) -> None:
        await self._backend.line.close()


def _back(why: str, is_service: bool) -> str:
    """Remedy that brings a board back, whose port could not be opened."""
    if is_service and why.partition("; ")[0] in _CLOSED_TO_SERVICES:
        return "plug it in, and open adapters to the service: the drop-in adapters.conf, `hil docs service`"
    return next((remedy for said, remedy in _BACK.items() if said in why), "plug it in")
