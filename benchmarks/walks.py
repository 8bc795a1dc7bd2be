"""Executed walks: what one byte, packet, frame, request or key runs through in the product's Python.

For each walk: calls, distinct functions, distinct files, lines of those files, rooms, and calls from one room
into another. A room is a folder below hil, or one profile, port or bridge. The live walks run in a daemon in
this process, whose event loop is followed; clients are in other threads, which are not. What a daemon does
beside them in that time is counted too, so their calls differ by some from run to run.

Limits are those of the design: more is a finding.
"""

import asyncio
import json
import os
import re
import socket
import struct
import sys
import time
import tty
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

import aiohttp
from _report import check_work, report

from device_profiles.sac.packet import encode
from hil.compose import find_catalogue
from hil.config import parse
from hil.daemon import Daemon, Serving
from hil.testing import Bench
from hil.vocab.desk_protocol import LOCAL, Encoded

ROOT = Path(__file__).parents[1]
PRODUCT = tuple(f"{ROOT}/{folder}/" for folder in ("hil", "bridges", "device_profiles", "virtual_ports"))
SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
UP_S = 4.5
"""Time after which a Mechaduino is at its menu."""
ENABLE, START = 0x0001, 8
MOVE_REGISTER, MOVE_COIL = 2000 + 32 * START, START
"""Parameters of ``move_abs`` and its start bit at the Modbus door: ``hil modbus map``."""
FIRST_ADDRESS = 4
BROADCAST_CALLS = 15
"""Calls of a node for a packet to all."""
SHORT_CONFIG = """bench: short
devices:
  m1: {profile: mechaduino, port: pty}
  s1: {profile: sac, port: tcp}
bridges:
  modbus: {}
  metrics: {}
# two devices and two doors: a short configuration of 200 characters
"""


@dataclass
class Walk:
    """Count of what one walk ran through. ``most_files``, ``most_rooms``, ``most_calls``: limits or None."""

    name: str
    most_files: int | None = None
    most_rooms: int | None = None
    most_calls: int | None = None
    calls: int = 0
    crossings: int = 0
    functions: set[tuple[str, str]] = field(default_factory=set)

    @contextmanager
    def walked(self) -> Iterator[None]:
        """Count this thread's calls meanwhile."""

        def note(frame: FrameType, event: str, _: object) -> None:
            if event != "call" or not (file := frame.f_code.co_filename).startswith(PRODUCT):
                return
            self.calls += 1
            self.functions.add((file, frame.f_code.co_qualname))
            caller = frame.f_back.f_code.co_filename if frame.f_back else ""
            self.crossings += caller.startswith(PRODUCT) and _room(caller) != _room(file)

        sys.setprofile(note)
        try:
            yield
        finally:
            sys.setprofile(None)

    @property
    def files(self) -> set[str]:
        return {file for file, _ in self.functions}

    @property
    def rooms(self) -> set[str]:
        return {_room(file) for file in self.files}

    def report(self) -> None:
        """Report the counts that have a limit, each beside it."""
        counted = (
            ("files", len(self.files), self.most_files),
            ("rooms", len(self.rooms), self.most_rooms),
            ("calls", self.calls, self.most_calls),
        )
        name = "_".join(re.findall(r"\w+", f"walk {self.name}".lower()))
        for what, count, most in counted:
            if most:
                about: dict[str, object] = {"reference": "the design's limit", "exact": True}
                report(f"{name}_{what}", count, what, most, 1.0, about)


def _room(file: str) -> str:
    return "/".join(file[len(str(ROOT)) + 1 :].split("/")[:2])


# ---- in the kit ----


@contextmanager
def line_of(nodes: int) -> Iterator[Bench]:
    """A bench with a line of SACs, each at an address of its own."""
    names = [f"s{number}" for number in range(nodes)]
    segments = {"bus0": {"stations": names, "taps": {"master": {"port": "memory"}}}}
    devices = {name: {"profile": "sac"} for name in names}
    with Bench({"bench": "t", "devices": devices, "segments": segments}) as bench:
        bench.run(ms=1100)
        for typed, wait_ms in (("$CM{}\r", 100), ("$R\r", 1200)):  # each its own address, and a restart
            for address, name in enumerate(names, FIRST_ADDRESS):
                bench.port(name).write(typed.format(address).encode())
            bench.run(ms=wait_ms)
        yield bench


def broadcast(nodes: int) -> Walk:
    """A packet from a tap to all SACs of a line, that only changes numbers."""
    walk = Walk(f"packet to all {nodes} SACs", most_calls=BROADCAST_CALLS * nodes)
    with line_of(nodes) as bench:
        tap, sent = bench.tap("bus0.master"), bench.segment("bus0").stats
        for speed in (b"v100", b"v101"):  # what is made once for all is made now
            tap.write(encode(0, 1, speed))
            bench.run(ms=20)
        before = sent.packets
        with walk.walked():
            tap.write(encode(0, 1, b"v100"))
            bench.run(ms=20)
        check_work("packets", sent.packets - before, 1)
    return walk


def packet(nodes: int) -> Walk:
    """An addressed packet from a tap to one SAC of a line, and its ACK back."""
    walk = Walk(f"packet to one of {nodes} SACs", most_calls=250)
    with line_of(nodes) as bench:
        tap = bench.tap("bus0.master")
        tap.write(encode(FIRST_ADDRESS, 1, b"y"))  # what is loaded late is loaded now
        bench.run(ms=50)
        tap.read()
        with walk.walked():
            tap.write(encode(FIRST_ADDRESS, 1, b"y"))
            bench.run(ms=50)
        check_work("bytes of an ACK", len(tap.read()), 7)
    return walk


def controlword() -> Walk:
    """A controlword from an slcan tap that gives a drive its set-point, and the 20 ms behind it: a motion."""
    walk = Walk("CAN controlword, 20 ms", most_files=36, most_calls=900)
    buses = {"can0": {"bit_rate": 1_000_000, "nodes": {"m1": 1}, "taps": {"slcan0": {}}}}
    with Bench({"bench": "t", "devices": {"m1": SERVO}, "can": buses}) as bench:
        bench.run(ms=UP_S * 1000)
        tap = bench.tap("can0.slcan0")
        tap.write(b"S8\rO\rt00020101\r")  # 1 Mbit/s; NMT: start node 1
        for word in (b"06", b"07", b"0F"):  # to operation enabled
            tap.write(b"t60182B406000" + word + b"000000\r")
            bench.run(ms=20)
        tap.write(b"t6018237A6000905F0100\r")  # 607Ah: 90 degrees
        bench.run(ms=20)
        check_work("answers", tap.read().count(b"t58186"), 4)
        with walk.walked():
            tap.write(b"t20121F00\r")
            bench.run(ms=20)
        shot = bench.axis("m1").snapshot()
        check_work("is moving", int(shot.position_deg > 0.01), 1)
    return walk


def configuration() -> Walk:
    """A configuration of 200 characters."""
    walk = Walk("configuration, 200 characters", most_calls=600)
    check_work("characters", len(SHORT_CONFIG), 200, 0.1)
    catalogue = find_catalogue()
    parse(SHORT_CONFIG, "short.yaml", catalogue)
    with walk.walked():
        config = parse(SHORT_CONFIG, "short.yaml", catalogue)
    check_work("devices", len(config.devices), 2)
    return walk


# ---- in a daemon ----


class Live:
    """A daemon in this process."""

    def __init__(self, serving: Serving, runtime: Path) -> None:
        self.serving, self.runtime = serving, runtime

    async def ask(self, operation: str, target: str = "", **given: Any) -> Any:
        answer = self.serving.desk.ask(LOCAL, operation, target, given)
        answer = await answer if isinstance(answer, Awaitable) else answer
        return json.loads(b"".join(answer.parts)) if isinstance(answer, Encoded) else answer

    async def byte(self) -> Walk:
        """A query typed at a pty, till its answer is whole."""
        walk = Walk("byte at a pty", most_files=28)
        fd = os.open(self.runtime / "walks" / "m1", os.O_RDWR | os.O_NOCTTY)
        tty.setraw(fd)

        def query() -> bytes:
            os.write(fd, b"p")
            answer = b""
            while not answer.endswith(b"\n"):
                answer += os.read(fd, 100)
            return answer

        await asyncio.to_thread(query)
        with walk.walked():
            answer = await asyncio.to_thread(query)
        os.close(fd)
        check_work("answers", answer.count(b"Angle"), 1)
        return walk

    async def modbus_write(self) -> Walk:
        """A start bit written over Modbus TCP, which moves an axis, till it is answered."""
        walk = Walk("Modbus write", most_files=30, most_rooms=9)
        status = await self.ask("status")
        host, _, port = status["bridges"]["modbus"]["listen"][0].rpartition(":")
        client = socket.create_connection((host, int(port)))

        def request(pdu: bytes) -> bytes:
            client.sendall(struct.pack(">HHHB", 1, 0, 1 + len(pdu), 1) + pdu)
            return client.recv(260)[7:]

        words = struct.pack(">f", 5.0)
        await asyncio.to_thread(request, struct.pack(">BHHB", 16, MOVE_REGISTER, 2, 4) + words)
        await self.ask("do", "m1", name="enable", parameters={})  # the query before has ended it
        with walk.walked():
            answer = await asyncio.to_thread(request, struct.pack(">BHH", 5, MOVE_COIL, 0xFF00))
        client.close()
        check_work("function of the answer", answer[0], 5)
        return walk

    async def watch(self) -> Walk:
        """A watch of a page, from its request to its first samples."""
        walk = Walk("watch of a page", most_files=20)
        url = (await self.ask("status"))["bridges"]["web"]["root"]
        asked = {"do": "watch", "what": "samples", "target": "m1", "fields": ["r"], "rate_Hz": 60}

        def watched(number: int, go: Callable[[], Any]) -> int:
            async def page() -> int:
                async with (
                    aiohttp.ClientSession() as session,
                    session.ws_connect(f"{url}ws", protocols=("hil.v1",)) as page,
                ):
                    await page.receive()
                    go()
                    await page.send_json({"id": number, **asked})
                    while (message := await page.receive()).type is not aiohttp.WSMsgType.BINARY:
                        pass
                    done()
                    return len(message.data)

            return asyncio.run(page())

        loop = asyncio.get_running_loop()
        begun, over = asyncio.Event(), asyncio.Event()

        def go() -> None:
            loop.call_soon_threadsafe(begun.set)
            time.sleep(0.2)  # the greeting has left

        def done() -> None:
            loop.call_soon_threadsafe(over.set)

        task = asyncio.create_task(asyncio.to_thread(watched, 1, go))
        await begun.wait()
        await asyncio.sleep(0.1)
        with walk.walked():
            await over.wait()
        check_work("samples", float(await task > 16), 1)
        return walk

    async def fault(self) -> Walk:
        """A fault injected at the desk."""
        walk = Walk("fault at the desk")
        with walk.walked():
            answer = await self.ask("inject", "m1", fault="shaft_load", parameters={"torque_Nm": 0.001})
        await self.ask("clear", "", number=answer["number"])
        return walk

    async def run(self) -> Walk:
        """A run submitted at the desk, till its axis follows."""
        walk = Walk("run at the desk")
        text = "run: r\naxes:\n  m2: {}\nsteps:\n  - line: {m2: 5}\n"
        with walk.walked():
            await self.ask("run", "", text=text, file="walk.yaml", fresh=True)
            while not (await self.ask("state", "m2"))["following"]:
                await asyncio.sleep(0.01)
        return walk


async def live_walks(folder: Path) -> list[Walk]:
    doors = {"modbus": {"listen": "127.0.0.1:0"}, "web": {"listen": 0}}
    devices = {"m1": SERVO, "m2": SERVO}
    config = json.dumps({"bench": "walks", "devices": devices, "bridges": doors})
    daemon = Daemon(
        parse(config, "walks.yaml", find_catalogue()),
        config_folder=folder,
        runtime_base=folder / "run",
        state_base=folder / "state",
    )
    started: asyncio.Future[Serving] = asyncio.get_running_loop().create_future()
    running = asyncio.create_task(daemon.run(started.set_result))
    live = Live(await started, folder / "run")
    try:
        await asyncio.sleep(UP_S)
        await live.ask("do", "m2", name="enable", parameters={})
        return [await walk() for walk in (live.byte, live.modbus_write, live.watch, live.fault, live.run)]
    finally:
        daemon.stop()
        await running


def table(walks: list[Walk]) -> Iterator[str]:
    """Lines for people."""
    yield f"{'walk':30}{'calls':>7}{'functions':>11}{'files':>7}{'lines':>7}{'rooms':>7}{'crossings':>11}"
    for walk in walks:
        lines = sum(Path(file).read_bytes().count(b"\n") for file in walk.files)
        counts = f"{walk.calls:7}{len(walk.functions):11}{len(walk.files):7}{lines:7}{len(walk.rooms):7}"
        yield f"{walk.name:30}{counts}{walk.crossings:11}"


def main() -> None:
    with TemporaryDirectory(prefix="hil-") as folder:
        walks = asyncio.run(live_walks(Path(folder)))
    walks += [packet(2), packet(252), broadcast(252), controlword(), configuration()]
    print(*table(walks), sep="\n", flush=True)
    if "--files" in sys.argv[1:]:
        for walk in walks:
            files = sorted(file[len(str(ROOT)) + 1 :] for file in walk.files)
            print(f"\n{walk.name}:", *files, sep="\n  ")
    for walk in walks:
        walk.report()


if __name__ == "__main__":
    main()
