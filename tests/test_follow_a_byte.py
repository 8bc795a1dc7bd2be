"""Pages ``docs/follow-a-*.md``: what they name exists, and what they tell is called in that order."""

import ast
import asyncio
import json
import re
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from struct import pack, unpack
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

import pytest
from aiohttp import ClientSession
from mentions import MENTION, definitions, is_defined

from hil.compose import find_catalogue
from hil.config import parse
from hil.daemon import Daemon, Serving
from hil.testing import Bench
from hil.vocab.desk_protocol import LOCAL
from hil.vocab.problem import ConfigError
from hil.vocab.time import NS_PER_S

ROOT = Path(__file__).parent.parent
PAGES = (
    "follow-a-byte",
    *sorted(path.stem for path in (ROOT / "docs").glob("follow-a-*.md") if path.stem != "follow-a-byte"),
)
UP_NS = 4.5 * NS_PER_S
"""Time after which a Mechaduino is at its menu."""
MOST_LINES = 75
"""Maximum length of a sister page: it is one page."""

Name = tuple[str, str]


def text_of(page: str) -> str:
    return (ROOT / "docs" / f"{page}.md").read_text()


MENTIONS = sorted({(page, *name) for page in PAGES for name in MENTION.findall(text_of(page))})


def test_the_pages_have_names_to_check() -> None:
    assert [page for page in PAGES if len(MENTION.findall(text_of(page))) < 20] == []
    assert len(MENTION.findall("`a/b.py: C.d` and `a/b.c:\n  f`, not `x.py` nor `C.d`")) == 2


@pytest.mark.parametrize("page", PAGES[1:])
def test_a_sister_is_one_page(page: str) -> None:
    assert len(text_of(page).splitlines()) <= MOST_LINES


@pytest.mark.parametrize(("page", "file", "name"), MENTIONS, ids=lambda part: part)
def test_a_name_exists(page: str, file: str, name: str) -> None:
    assert (ROOT / file).is_file(), f"{page} mentions {file}, which does not exist"
    assert is_defined(ROOT / file, name), f"{page} mentions {name} in {file}, which does not define it"


# ---- what is told is called ----


@contextmanager
def called(into: list[Name]) -> Iterator[None]:
    """Note each call of a function of the project, in order, in threads that begin meanwhile, too."""

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(str(ROOT)):
            into.append((frame.f_code.co_filename[len(str(ROOT)) + 1 :], frame.f_code.co_qualname))

    before, before_in_threads = sys.getprofile(), threading.getprofile()
    threading.setprofile(note)
    sys.setprofile(note)
    try:
        yield
    finally:
        sys.setprofile(before)
        threading.setprofile(before_in_threads)


def typed_p() -> list[Name]:
    """``p`` at a Mechaduino."""
    calls: list[Name] = []
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        bench.run(ms=5000)
        with called(calls):
            bench.port("m1").write(b"p")
            bench.run(ms=200)
        assert b"Angle: " in bench.port("m1").read()
    return calls


def typed_for_another() -> list[Name]:
    """``86m3000`` at the SAC with the address 85."""
    calls: list[Name] = []
    devices = {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}}
    segments = {"bus0": {"stations": ["s1", "s2"]}}
    with Bench({"bench": "t", "devices": devices, "segments": segments}) as bench:
        bench.run(ms=1100)
        for name, address in (("s1", 85), ("s2", 86)):
            bench.port(name).write(b"$CM%d\r" % address)
            bench.run(ms=100)
            bench.port(name).write(b"$R\r")
            bench.run(ms=200)
        with called(calls):
            bench.port("s1").write(b"86m3000\r")
            bench.run(ms=100)
        assert bench.axis("s2").snapshot().motion_state
    return calls


def asked_to_move() -> list[Name]:
    """``move_abs`` of a Mechaduino that is calibrated."""
    calls: list[Name] = []
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        axis = bench.axis("m1")
        bench.run(ms=5000)
        axis.do("calibrate")
        bench.run(ms=40_000)
        axis.do("enable")
        with called(calls):
            axis.do("move_abs", position_deg=90.0)
        assert axis.snapshot().following
    return calls


def in_a_daemon(folder: Path, bench: object, act: Callable[[Serving], Awaitable[None]]) -> None:
    """Act at a bench in a daemon, whose file is ``t.yaml`` in the folder, and end it."""
    file = folder / "t.yaml"
    config = parse(json.dumps(bench), str(file), find_catalogue())
    bases = {"runtime_base": folder / "run", "state_base": folder / "state"}

    async def main() -> None:
        daemon = Daemon(config, config_folder=folder, config_file=file, **bases)

        async def doing(serving: Serving) -> None:
            try:
                await act(serving)
            finally:
                daemon.stop()

        tasks: list[asyncio.Task[None]] = []
        await daemon.run(lambda serving: tasks.append(asyncio.get_running_loop().create_task(doing(serving))))
        await tasks[0]

    asyncio.run(main())


async def status_of(serving: Serving) -> Any:
    return json.loads(b"".join((await serving.desk.ask(LOCAL, "status", "", {})).parts))


@cache
def reloaded() -> list[Name]:
    """A reload after which m1 is as it was, m2 begins elsewhere, m3 is new and m4 gone."""
    calls: list[Name] = []
    board = {"profile": "mechaduino"}
    before = {"bench": "t", "devices": {"m1": board, "m2": board, "m4": board}}
    after = {
        "bench": "t",
        "devices": {"m1": board, "m2": {**board, "axis": {"start_deg": 90.0}}, "m3": board},
        "faults": [{"fault": "shaft_load", "target": "m3", "torque_Nm": 0.01}],
    }
    done: dict[str, list[str]] = {}

    with TemporaryDirectory() as name:
        folder = Path(name)

        async def ask(serving: Serving) -> None:
            (folder / "state" / "t" / "m3.nvm").write_text("what no board has written")
            (folder / "t.yaml").write_text(json.dumps(after))
            with called(calls):
                done.update(await serving.desk.ask(LOCAL, "reload", "", {}))

        in_a_daemon(folder, before, ask)
    assert done == {"kept": ["m1"], "restarted": ["m2"], "added": ["m3"], "removed": ["m4"]}
    return calls


@cache
def watched() -> list[Name]:
    """Two fields of a Mechaduino, watched at the page's WebSocket until the first samples are there."""
    calls: list[Name] = []
    wanted = {"what": "samples", "target": "m1", "fields": ["r", "yw"], "rate_Hz": 60}

    async def watch(serving: Serving) -> None:
        status = await status_of(serving)
        url = status["bridges"]["web"]["root"] + "ws"
        async with ClientSession() as session, session.ws_connect(url, protocols=("hil.v1",)) as page:
            assert "hello" in await page.receive_json()
            with called(calls):
                await page.send_json({"id": 1, "do": "watch", **wanted})
                assert await page.receive_json() == {"id": 1, "answer": {"watch": 1}}
                await page.receive_bytes()

    bench = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}, "bridges": {"web": {"listen": 0}}}
    with TemporaryDirectory() as name:
        in_a_daemon(Path(name), bench, watch)
    return calls


@cache
def started_over_modbus() -> list[Name]:
    """The start bit of ``move_abs`` of a Mechaduino, written at the Modbus door and answered."""
    calls: list[Name] = []
    coil = 8
    registers = 2000 + 32 * coil

    async def write(serving: Serving) -> None:
        status = await status_of(serving)
        host, _, port = status["bridges"]["modbus"]["listen"][0].rpartition(":")
        reader, writer = await asyncio.open_connection(host, int(port))

        async def answered(pdu: bytes) -> bytes:
            writer.write(pack(">HHHB", 1, 0, len(pdu) + 1, 1) + pdu)
            length = unpack(">HHHB", await reader.readexactly(7))[2]
            return await reader.readexactly(length - 1)

        while (await status_of(serving))["sim_ns"] < UP_NS:
            await asyncio.sleep(0.1)
        await answered(pack(">BHHBf", 16, registers, 2, 4, 5.0))
        serving.desk.ask(LOCAL, "do", "m1", {"name": "enable", "parameters": {}})
        start = pack(">BHH", 5, coil, 0xFF00)
        with called(calls):
            assert await answered(start) == start
            await asyncio.sleep(0)  # the wait for the motion's end begins
        writer.close()

    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    bench = {"bench": "t", "devices": {"m1": servo}, "bridges": {"modbus": {"listen": "127.0.0.1:0"}}}
    with TemporaryDirectory() as name:
        in_a_daemon(Path(name), bench, write)
    return calls


def pulled() -> list[Name]:
    """A load at the shaft of a Mechaduino."""
    calls: list[Name] = []
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        bench.run(ms=100)
        with called(calls):
            bench.fault("shaft_load", "m1", torque_Nm=0.02)
            bench.run(ms=1)
        assert bench.axis("m1").snapshot().load_torque_Nm == 0.02
    return calls


def checked() -> list[Name]:
    """A configuration in which a load has an inertia, and one in which it cannot be that."""
    calls: list[Name] = []
    catalogue = find_catalogue()

    def text(inertia_kg_m2: float) -> str:
        axis = {"inertia_kg_m2": inertia_kg_m2}
        return json.dumps({"bench": "t", "devices": {"m1": {"profile": "mechaduino", "axis": axis}}})

    with called(calls):
        parse(text(2.0e-5), "t.yaml", catalogue)
    with pytest.raises(ConfigError, match="inertia_kg_m2"):
        parse(text(1.0e300), "t.yaml", catalogue)
    return calls


@cache
def run() -> list[Name]:
    """A run in which two Mechaduinos turn along a line."""
    calls: list[Name] = []
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    text = "{run: r, axes: {m1: {}, m2: {}}, steps: [{line: {m1: 30, m2: 15}}]}"
    with Bench({"bench": "t", "devices": {"m1": servo, "m2": servo}}) as bench:
        bench.run(ms=5000)
        for name in ("m1", "m2"):
            bench.axis(name).do("enable")
        with called(calls):
            assert bench.perform(text).state == "done"
    return calls


@cache
def enabled_over_can() -> list[Name]:
    """The controlword that enables a drive, at an slcan tap."""
    calls: list[Name] = []
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    bus = {"bit_rate": 1_000_000, "taps": {"slcan0": {}}, "nodes": {"m1": {"id": 1}}}
    with Bench({"bench": "t", "devices": {"m1": servo}, "can": {"can0": bus}}) as bench:
        tap = bench.tap("can0.slcan0")
        bench.run(ms=5000)
        for line in (b"S8", b"O", b"t60182300180181010000", b"t00020101", b"t20120600", b"t20120700"):
            tap.write(line + b"\r")
            bench.run(ms=5)
        tap.read()
        with called(calls):
            tap.write(b"t20120F00\r")
            bench.run(ms=5)
        assert tap.read() == b"z\rt18123706\r"
    return calls


TOLD: dict[tuple[str, str], Callable[[], list[Name]]] = {
    ("follow-a-byte", "### 2. The firmware wakes"): typed_p,
    ("follow-a-packet", "## From one board to the other"): typed_for_another,
    ("follow-a-command", "## In simulated time"): asked_to_move,
    ("follow-a-reload", "## Steps that can fail"): reloaded,
    ("follow-a-reload", "## In one step"): reloaded,
    ("follow-a-fault", "## In simulated time"): pulled,
    ("follow-a-key", "## The checks"): checked,
    ("follow-a-watch", "## The request"): watched,
    ("follow-a-watch", "## The samples"): watched,
    ("follow-a-modbus-write", "## The request"): started_over_modbus,
    ("follow-a-modbus-write", "## The verb"): started_over_modbus,
    ("follow-a-can-frame", "## The bus"): enabled_over_can,
    ("follow-a-can-frame", "## The node"): enabled_over_can,
    ("follow-a-run", "## The plan"): run,
    ("follow-a-run", "## In simulated time"): run,
}
"""Sections whose Python functions are called in the order in which they are named, by what calls them."""
REAL_TIME = ("hil/live/", "hil/sim/input_log.py", "virtual_ports/pty/")
"""Places of code that the kit does not run."""
IN_A_DAEMON = (reloaded, watched, started_over_modbus)
"""Acts in a daemon, which runs the code of ``REAL_TIME`` too."""


@pytest.mark.parametrize(("page", "heading"), TOLD, ids=lambda part: part)
def test_what_is_told_is_called_in_that_order(page: str, heading: str) -> None:
    section = re.split(r"^#", text_of(page).partition(f"\n{heading}\n")[2], maxsplit=1, flags=re.M)[0]
    told = [
        (file, name)
        for file, name in MENTION.findall(section)
        if file.endswith(".py")
        and (TOLD[page, heading] in IN_A_DAEMON or not file.startswith(REAL_TIME))
        and isinstance(definitions(ROOT / file)[name], ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    assert len(told) > 5
    calls = iter(TOLD[page, heading]())
    missing = next((name for name in told if name not in calls), None)  # each is sought behind the one before
    assert missing is None
