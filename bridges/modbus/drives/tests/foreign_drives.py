"""Drives of another hand: pymodbus's servers with plain registers and a ramp, at TCP or at a pty; and one
that answers as it likes."""

import asyncio
import os
import struct
import time
import tty
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from pymodbus.server import ModbusSerialServer, ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from bridges.modbus.maps.drive_map_text import read_drive_map
from bridges.modbus.registers.drive_map import DriveMap

MAP = """
modbus_map: 1
position_deg: {input: 0, type: i32, scale: 0.01}
velocity_rpm: {input: 2, type: i16, scale: 0.1}
status: {enabled: {input: 4, bit: 0}, moving: {input: 4, bit: 1}, fault: {input: 4, bit: 2}}
fault_code: {input: 5}
set_point_deg: {holding: 10, type: i32, scale: 0.01}
set_velocity_rpm: {holding: 12}
control:
  enable: {holding: 20, bit: 0}
  start: {holding: 20, bit: 1}
  stop: {holding: 20, bit: 2}
  reset: {holding: 20, bit: 3}
  follow: {holding: 20, bit: 4}
parameters: {pKp: {holding: 30, type: f32}}
"""
ENABLE, START, STOP, RESET, FOLLOW = 1, 2, 4, 8, 16
TICK_S = 0.002
FAST_DEG_PER_S = 2000.0


def drive_map(without: str = "") -> DriveMap:
    """Map of these drives, without the line of one control bit."""
    lines = [line for line in MAP.splitlines() if not without or not line.strip().startswith(f"{without}:")]
    return read_drive_map("\n".join(lines), "map.yaml")


class Ramp:
    """Drive behind registers: what it does each tick with those of one unit."""

    def __init__(self, position_deg: float = 0.0) -> None:
        self.position_deg, self.target_deg = position_deg, position_deg
        self.control, self.is_stuck, self.fault = 0, False, 0
        self.starts, self.moves = 0, False
        self._at_s = time.monotonic()

    def step(self, control: int, set_deg: float, set_rpm: int) -> tuple[int, ...]:
        """Take the registers 10 to 20, and answer those from 0 to 5."""
        rose = control & ~self.control
        self.control = control
        now_s = time.monotonic()
        seconds, self._at_s = now_s - self._at_s, now_s
        if rose & RESET:
            self.fault = 0
        is_on = bool(control & ENABLE) and not self.fault
        if not is_on or rose & STOP:
            self.target_deg = self.position_deg
        elif rose & START:
            self.target_deg, self.starts = set_deg, self.starts + 1
        elif control & FOLLOW:
            self.target_deg = set_deg
        speed = FAST_DEG_PER_S if control & FOLLOW else (set_rpm or 60) * 6.0
        left_deg = self.target_deg - self.position_deg
        step_deg = 0.0 if self.is_stuck else max(min(left_deg, speed * seconds), -speed * seconds)
        self.position_deg += step_deg
        self.moves = abs(self.target_deg - self.position_deg) > 0.005
        status = is_on | self.moves << 1 | bool(self.fault) << 2
        rpm = round(step_deg / max(seconds, 1e-6) / 6.0 * 10)
        words = struct.unpack(">HH", struct.pack(">i", round(self.position_deg * 100)))
        return (*words, max(min(rpm, 32767), -32768) & 0xFFFF, 0, status, self.fault)


def _pass_on(source: int, ends: tuple[int, ...]) -> None:
    data = os.read(source, 4096)
    for end in ends:
        os.write(end, data)


class ForeignDrives:
    """Units on one line, of pymodbus's own server. ``ramps``: by unit."""

    def __init__(self, *units: int) -> None:
        self.ramps = {unit: Ramp() for unit in units}
        self.server: Any = None
        self.path = ""
        self._fds: list[int] = []
        self._task: asyncio.Task[None] | None = None

    def _devices(self) -> list[SimDevice]:
        data = [SimData(0, count=60, values=0, datatype=DataType.REGISTERS)]
        return [SimDevice(unit, data) for unit in self.ramps]

    async def listen(self, port: int = 0) -> int:
        """Listen at TCP; answers the port."""
        self.server = ModbusTcpServer(self._devices(), address=("127.0.0.1", port))
        await self.server.serve_forever(background=True)
        self._task = asyncio.get_running_loop().create_task(self._run())
        return int(self.server.transport.sockets[0].getsockname()[1])

    async def sit_at_pty(self, *, echoes: bool = False) -> str:
        """Sit at one end of a line of two pseudo-terminals; answers the other end's path. ``echoes``: what is
        sent at that end comes back there."""
        ends = [os.openpty() for _ in range(2)]
        for fd in (fd for end in ends for fd in end):
            tty.setraw(fd)
        masters = [master for master, _ in ends]
        self._fds = [fd for end in ends for fd in end]
        loop = asyncio.get_running_loop()
        for one, other in (masters, masters[::-1]):
            os.set_blocking(one, False)
            others = (other, one) if echoes and one == masters[1] else (other,)
            loop.add_reader(one, _pass_on, one, others)
        paths = [os.ttyname(slave) for _, slave in ends]

        def of_those_here(is_sending: bool, data: bytes) -> bytes:
            """pymodbus's server answers for units that it has not, too, as no line does."""
            return b"" if is_sending and data[0] not in self.ramps else data

        self.server = ModbusSerialServer(
            self._devices(), port=paths[0], baudrate=19200, trace_packet=of_those_here
        )
        await self.server.serve_forever(background=True)
        self._task = loop.create_task(self._run())
        return paths[1]

    async def _run(self) -> None:
        while True:
            for unit, ramp in self.ramps.items():
                words = await self.server.async_getValues(unit, 3, 10, 11)
                (hundredths,) = struct.unpack(">i", struct.pack(">HH", *words[:2]))
                told = ramp.step(words[10], hundredths / 100, words[2])
                await self.server.async_setValues(unit, 16, 0, list(told))
            await asyncio.sleep(TICK_S)

    async def word(self, unit: int, address: int) -> int:
        return int((await self.server.async_getValues(unit, 3, address, 1))[0])

    async def set_word(self, unit: int, address: int, word: int) -> None:
        await self.server.async_setValues(unit, 16, address, [word])

    async def close(self) -> None:
        if self._task:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
        if self.server:
            await self.server.shutdown()
        for fd in self._fds:
            asyncio.get_running_loop().remove_reader(fd)
            os.close(fd)


Answering = Callable[[bytes, asyncio.StreamWriter], Awaitable[None]]


class HostileDrive:
    """Listener that answers each request as ``answer`` likes. ``heard``: the requests."""

    def __init__(self, answer: Answering) -> None:
        self.answer = answer
        self.heard: list[bytes] = []
        self.connects = 0
        self._server: asyncio.Server | None = None
        self._writers: list[asyncio.StreamWriter] = []

    async def listen(self, port: int = 0) -> int:
        self._server = await asyncio.start_server(self._client, "127.0.0.1", port)
        return int(self._server.sockets[0].getsockname()[1])

    async def _client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.connects += 1
        self._writers.append(writer)
        with suppress(OSError, asyncio.IncompleteReadError):
            while True:
                head = await reader.readexactly(6)
                request = head + await reader.readexactly(int.from_bytes(head[4:6], "big"))
                self.heard.append(request)
                await self.answer(request, writer)
        writer.close()

    def cut(self) -> None:
        """Cut all connections."""
        for writer in self._writers:
            writer.transport.abort()
        self._writers.clear()

    async def close(self) -> None:
        self.cut()
        if self._server:
            self._server.close()
            await self._server.wait_closed()


def framed(request: bytes, pdu: bytes, *, transaction: int | None = None, unit: int | None = None) -> bytes:
    """Answer to a request, as another transaction's or unit's if that is given."""
    number = int.from_bytes(request[:2], "big") if transaction is None else transaction
    return struct.pack(">HHHB", number, 0, len(pdu) + 1, request[6] if unit is None else unit) + pdu


class Registers:
    """Registers of a drive that does all right and does not move, for answers of a hostile one."""

    def __init__(self) -> None:
        self.words = [0] * 64
        self.words[4] = 1

    def pdu(self, request: bytes) -> bytes:
        """PDU that answers a request properly."""
        code, address, count = struct.unpack(">BHH", request[7:12])
        if code in (3, 4):
            words = self.words[address : address + count]
            return struct.pack(f">BB{count}H", code, 2 * count, *words)
        if code == 6:
            self.words[address] = count
        if code == 16:
            self.words[address : address + count] = struct.unpack(f">{count}H", request[13:])
        return request[7:12]
