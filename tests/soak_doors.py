"""Clients of the mixed soak at further doors: pages that read and pages that do not, masters of a CAN bus,
drawings, and a serial adapter that echoes."""

import asyncio
import os
import select
import struct
import threading
import tty
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import aiohttp
import soak_inputs as inputs
from e2e_support import Client
from soak_clients import ASK_S, Actor, Scene

SAVE, LOAD = 0x65766173, 0x64616F6C
"""Signatures of CiA 301 for 1010h and 1011h."""
PLANS_S = 300.0
"""Maximum wait for a drawing, which is planned when nothing else is to do, one at a time."""
WATCHES = ("samples", "packets", "frames", "bytes", "runs", "status", "faults")
PROTOCOL = "hil.v1"
CLOSES = aiohttp.ClientWSTimeout(ws_close=0.2)
MACHINE = """\
machine: plotter
axes:
  x: {axis: m1, deg_per_mm: 9, min_mm: -90, max_mm: 90, velocity_mm_per_min: 4000, acceleration_mm_per_s2: 99}
"""


class EchoingAdapter(threading.Thread):
    """A serial port with an adapter whose receiver stays on while it sends: what is written comes back. Now
    and then another node speaks."""

    def __init__(self, random: Random, folder: Path) -> None:
        super().__init__(name="adapter", daemon=True)
        self._random = random
        self._ours, theirs = os.openpty()
        for fd in (self._ours, theirs):
            tty.setraw(fd)
        self._theirs = theirs  # kept open: a line whose last client has gone hangs up
        self.path = str(folder / "adapter")
        os.symlink(os.ttyname(theirs), self.path)
        self._over = threading.Event()

    def run(self) -> None:
        with suppress(OSError):
            while not self._over.is_set():
                if select.select([self._ours], [], [], 0.05)[0]:
                    os.write(self._ours, os.read(self._ours, 4096))
                elif self._random.random() < 0.1:
                    os.write(self._ours, inputs.on_wire(self._random))

    def end(self) -> None:
        self._over.set()
        self.join(ASK_S)
        os.close(self._ours)
        os.close(self._theirs)


class CanMaster(Actor):
    """Master at an slcan adapter: SDO, PDO and NMT, and much that is stored."""

    pause_s = 0.05
    NODE = 5

    def __init__(self, scene: Scene, name: str, address: str) -> None:
        super().__init__(scene, f"master at {name}")
        self.address = address.replace("rfc2217://", "socket://")
        self.client: Client | None = None

    def act(self) -> None:
        with suppress(OSError):
            if self.client is None:
                self.client = Client(self.address)
                self.client.write_until_full(b"C\rS6\rO\r")
            self.client.write_until_full(
                b"".join(self._frame() for _ in range(self.chance.choice((1, 1, 3, 20))))
            )
            self.scene.counts["heard on CAN"] += len(self.client.quiet(0))
            if self.chance.random() > 0.02:
                return
        self.end()

    def _frame(self) -> bytes:
        chance = self.chance
        match chance.choice(("read", "write", "write", "save", "nmt", "sync", "pdo", "lss", "any")):
            case "read":
                return self._sdo(0x40, chance.choice((0x1000, 0x1018, 0x6041, 0x6064, 0x6081)), 0, 0)
            case "write":
                index, value = chance.choice(((0x6081, 5000), (0x6083, 9000), (0x607A, 300), (0x6040, 0xF)))
                return self._sdo(0x23 if index != 0x6040 else 0x2B, index, 0, chance.randint(0, value))
            case "save":
                index, what = chance.choice(((0x1010, SAVE), (0x1010, SAVE), (0x1011, LOAD)))
                return self._sdo(0x23, index, chance.choice((1, 1, 2, 9)), what)
            case "nmt":
                return b"t0002%02X%02X\r" % (
                    chance.choice((1, 1, 2, 128, 129, 130)),
                    chance.choice((0, self.NODE)),
                )
            case "sync":
                return b"t0800\r"
            case "pdo":
                return b"t%03X2%02X00\r" % (0x200 + self.NODE, chance.choice((6, 7, 15, 31)))
            case "lss":
                return b"t7E58%s\r" % bytes(
                    (chance.choice((4, 17, 23, 94)), chance.randint(0, 2))
                ).hex().encode().ljust(16, b"0")
        data = chance.randbytes(chance.randint(0, 8))
        return b"t%03X%d%s\r" % (chance.randrange(0x800), len(data), data.hex().upper().encode())

    def _sdo(self, command: int, index: int, sub: int, value: int) -> bytes:
        data = struct.pack("<BHBI", command, index, sub, value)
        return b"t%03X8%s\r" % (0x600 + self.NODE, data.hex().upper().encode())

    def end(self) -> None:
        if self.client:
            self.client.close()
            self.client = None


def program(random: Random) -> str:
    """A program in G-code of chance: short, long, or with many turns."""
    lines = [random.choice(("G21 G90 G64 P0.1", "G21 G90 G61", ""))]
    for _ in range(random.choice((1, 5, 60, 800))):
        word = random.choice(("G0", "G1", "G1", "G1", "G4 P0.01 G1", "G2", "M0", "nonsense"))
        turns = f" Y0 I10 J0 P{random.choice((1, 3, 50))}" if word == "G2" else ""
        lines.append(f"{word} X{random.gauss(0, 20):.3f}{turns} F{random.choice((100, 3000))}")
    return "\n".join([*lines, "M2"])


class Drawer(Actor):
    """Draws programs by the bench's servos."""

    pause_s = 1.0

    def act(self) -> None:
        answer = self.scene.ask("drawing", PLANS_S, text=program(self.chance), machine=MACHINE)
        for run in (answer or {}).get("runs", ())[:1]:
            self.scene.ask("run", text=run["text"], file="drawing", fresh=True)
        self.scene.counts["drawings"] += 1


class Page(Actor):
    """A page of the web bridge that comes and goes; a bad one does not read what it asked for: buffers of
    its client fill, then the kernel's, then the bench's."""

    def __init__(self, scene: Scene, name: str, url: str, *, reads: bool) -> None:
        super().__init__(scene, name)
        self.url, self.reads = url, reads

    def act(self) -> None:
        with suppress(aiohttp.ClientError, TimeoutError, ConnectionError):
            asyncio.run(asyncio.wait_for(self._visit(), ASK_S))

    async def _visit(self) -> None:
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(self.url, protocols=(PROTOCOL,), timeout=CLOSES, max_msg_size=0) as socket,
        ):
            self.scene.counts["pages"] += 1
            loop = asyncio.get_running_loop()
            leaves_s = loop.time() + self.chance.uniform(0.5, 5)
            number = 0
            while not self.scene.over.is_set() and loop.time() < leaves_s:
                number += 1
                await asyncio.wait_for(socket.send_json({"id": number, **self._request()}), 1)
                if self.reads:
                    await self._read(socket)
                await asyncio.sleep(0.02)

    async def _read(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        with suppress(TimeoutError):
            while True:
                came = await socket.receive(timeout=self.chance.uniform(0.01, 0.2))
                if came.type not in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY):
                    raise ConnectionError("the bench closed it")
                self.scene.counts["pushed"] += len(came.data)

    def _request(self) -> dict[str, Any]:
        chance, names = self.chance, list(self.scene.profiles)
        match chance.choice(("watch", "watch", "export", "status", "drawing", "plan", "open", "end")):
            case "watch":
                what = chance.choice(WATCHES)
                target = {"packets": "bus0", "frames": "can0"}.get(what) or chance.choice(names)
                return {"do": "watch", "what": what, "target": "" if what in WATCHES[4:] else target}
            case "export":
                return {"do": "export", "watch": chance.randint(1, 20)}
            case "status":
                return {"do": "ask", "operation": chance.choice(("status", "list", "health", "runs"))}
            case "drawing":
                return {"do": "ask", "operation": "drawing"}
            case "plan":
                given = {"text": program(chance), "machine": MACHINE}
                return {"do": "ask", "operation": "drawing", "given": given}
            case "open":
                return {"do": "open", "port": chance.choice(names)}
        return {"do": chance.choice(("unwatch", "close")), "watch": chance.randint(1, 20)}


def pages(scene: Scene, url: str) -> list[Actor]:
    return [
        Page(scene, "page", url, reads=True),
        Page(scene, "other page", url, reads=True),
        Page(scene, "deaf page", url, reads=False),
    ]


def can_masters(scene: Scene) -> list[Actor]:
    """Make the masters at the adapters of a bench's CAN bus."""
    taps = [row for row in scene.ask("list")["taps"] if row["tap"].startswith("can0.")]
    return [CanMaster(scene, row["tap"], row["port"]) for row in taps]
