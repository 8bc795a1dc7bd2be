"""The web bridge of a bench that runs: what pages see of boards, wires and runs, and what they may do."""

import asyncio
import base64
import json
import struct
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from desk_support import CONFIG, Asking, desk_in
from e2e_support import PATIENCE_S, READY_NS
from markdown_blocks import block

from bridges.web.password_hash import hash_of
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import Role
from hil.wire import pcapng

PASSWORD = "long and green"
DEVICES = {
    "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    "s1": {"profile": "sac"},
    "s10": {"profile": "sac", "port": {"kind": "tcp"}},
    "s2": {"profile": "sac", "port": {"kind": "rfc2217"}},
}


def text(**web: Any) -> str:
    return json.dumps({**json.loads(CONFIG), "devices": DEVICES, "bridges": {"web": {"listen": 0, **web}}})


class Page:
    """A page's WebSocket."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket, self._last = socket, 0
        self._pushed: list[Any] = []

    async def ask(self, do: str, **given: Any) -> Any:
        """Ask; answers the answer, or the error."""
        self._last += 1
        number = self._last
        await self._socket.send_json({"id": number, "do": do, **given})
        found = await self.until(lambda each: isinstance(each, dict) and each.get("id") == number)
        return found.get("answer", found.get("error"))

    async def until(self, fits: Callable[[Any], Any]) -> Any:
        """First message that fits and was not taken."""
        async with asyncio.timeout(PATIENCE_S):
            while True:
                for message in self._pushed:
                    if fits(message):
                        self._pushed.remove(message)
                        return message
                came = await self._socket.receive()
                assert came.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY), came
                self._pushed.append(json.loads(came.data) if isinstance(came.data, str) else came.data)

    async def type(self, terminal: int, data: bytes) -> None:
        await self._socket.send_bytes(struct.pack("<BBHI", 2, 0, 0, terminal) + data)

    async def said(self, terminal: int, end: bytes) -> bytes:
        """What a terminal says, until it ends so."""
        heard, head = b"", struct.pack("<BBHI", 2, 0, 0, terminal)
        while end not in heard:
            heard += (await self.until(lambda each: isinstance(each, bytes) and each.startswith(head)))[8:]
        return heard


def url_of(bench: Asking) -> str:
    root: str = bench.serving.live.bridges["web"].status()["root"]
    return root


@asynccontextmanager
async def page_of(bench: Asking, user: str = "") -> AsyncIterator[Page]:
    jar = aiohttp.CookieJar(unsafe=True)
    async with aiohttp.ClientSession(cookie_jar=jar) as session:
        if user:
            given = {"user": user, "password": PASSWORD}
            async with session.post(f"{url_of(bench)}api/login", json=given) as answer:
                assert answer.status == 204
        async with session.ws_connect(f"{url_of(bench)}ws", protocols=("hil.v1",), max_msg_size=0) as socket:
            yield Page(socket)


def with_page(folder: Path, use: Callable[[Asking, Page], Awaitable[None]]) -> None:
    async def bench_with_page(bench: Asking) -> None:
        async with page_of(bench) as page:
            await use(bench, page)

    desk_in(folder, text())(bench_with_page)


def test_an_axis_is_watched_while_it_moves(tmp_path: Path) -> None:
    async def use(bench: Asking, page: Page) -> None:
        hello = (await page.until(lambda each: "hello" in each))["hello"]
        m1 = next(device for device in hello["devices"] if device["name"] == "m1")
        assert m1["verbs"]["move_abs"]["parameters"][0]["unit"] == "deg"
        assert {"name": "bus0", "framing": "sac", "baud": 38400, "format": "8N1"} in hello["segments"]
        assert set(hello["ports"]) >= {"m1", "s1", "bus0.t"}
        await bench.until_ready("m1")
        fields = ["position_deg", "at_ns"]
        await page.ask("watch", what="samples", target="m1", fields=fields, rate_Hz=50)
        for verb, parameters in (("enable", {}), ("move_abs", {"position_deg": 90})):
            done = await page.ask(
                "ask", operation="do", target="m1", given={"name": verb, "parameters": parameters}
            )
            assert done["effective_at_ns"] > 0, done
        rows: list[tuple[float, ...]] = []
        while not rows or abs(rows[-1][1] - 90) > 1:
            data = await page.until(lambda each: isinstance(each, bytes))
            count = struct.unpack_from("<I", data, 12)[0]
            rows += struct.iter_unpack("<3d", data[16 : 16 + 24 * count])
        assert all(at_s == at_ns / 1e9 for at_s, _, at_ns in rows)
        steps = {round((other[2] - one[2]) / 20e6, 6) for one, other in pairwise(rows)}
        assert steps == {1.0}  # none is lost, none comes twice

    with_page(tmp_path, use)


def test_terminals_at_ports_of_all_kinds_are_shared_by_pages(tmp_path: Path) -> None:
    async def use(bench: Asking, page: Page) -> None:
        await bench.until_ready("s1", 1_300_000_000)
        async with page_of(bench) as other:
            for name in ("s1", "s10", "s2"):
                one, two = await page.ask("open", port=name), await other.ask("open", port=name)
                assert (one["clients"], two["clients"]) == (0, 1)
                await page.type(one["terminal"], b"vd\r")
                assert b"\r\n" in await page.said(one["terminal"], b"SAC>")
                await other.said(two["terminal"], b"SAC>")
            await page.ask("close", terminal=1)
            await other.type(1, b"\r")
            await other.said(1, b"SAC>")
        assert (await page.ask("open", port="s9"))["code"] == "no_place"
        assert "did you mean" in (await page.ask("open", port="s11"))["message"]
        await page.type(99, b"nobody is there")
        assert await page.ask("close", terminal=99) == {}

    with_page(tmp_path, use)


def test_a_terminal_types_what_it_is_given_and_shows_what_comes(tmp_path: Path) -> None:
    """Escape sequences and bytes that are no UTF-8 are bytes."""

    async def use(bench: Asking, page: Page) -> None:
        await bench.until_ready("s1", 1_300_000_000)
        terminal = (await page.ask("open", port="bus0.t"))["terminal"]
        await page.ask("watch", what="bytes", target="bus0.t")
        typed = b"\x1b]0;x\x07\xff\xfe\x00\x9b31m"
        await page.type(terminal, typed)
        heard = ""
        while bytes.fromhex(heard) != typed:
            pushed = await page.until(lambda each: isinstance(each, dict) and "items" in each)
            heard += "".join(item["hex"] for item in pushed["items"] if item["to"] == "board")

    with_page(tmp_path, use)


def test_packets_are_seen_sent_and_exported(tmp_path: Path) -> None:
    async def use(bench: Asking, page: Page) -> None:
        await bench.until_ready("s1", 1_300_000_000)
        watch = (await page.ask("watch", what="packets", target="bus0"))["watch"]
        assert (await page.ask("send", segment="bus0", data_hex="02 10 03"))["effective_at_ns"] > 0
        (item,) = (await page.until(lambda each: isinstance(each, dict) and "items" in each))["items"]
        assert (item["hex"], item["duration_s"]) == ("021003", 30 / 38400)
        assert item["error"]
        exported = await page.ask("export", watch=watch)
        (record,) = pcapng.read(base64.b64decode(exported["pcapng_base64"]))
        assert (record.data, record.line.name, record.line.baud) == (b"\x02\x10\x03", "bus0", 38400)
        assert (await page.ask("send", segment="bus9", data_hex="00"))["code"] == "no_place"
        assert (await page.ask("send", segment="bus0", data_hex="0g"))["code"] == "bad_parameter"
        assert (await page.ask("export", watch=99))["code"] == "no_place"

    with_page(tmp_path, use)


def test_runs_and_faults_are_told(tmp_path: Path) -> None:
    async def use(bench: Asking, page: Page) -> None:
        await bench.until_ready("m1")
        await page.ask("watch", what="faults")
        await page.ask("watch", what="runs")
        jam = {"fault": "shaft_jam", "parameters": {}}
        number = (await page.ask("ask", operation="inject", target="m1", given=jam))["number"]
        told = await page.until(lambda each: isinstance(each, dict) and each.get("value"))
        assert [fault["kind"] for fault in told["value"]] == ["shaft_jam"]
        assert (
            READY_NS < told["value"][0]["begin_ns"] <= (await page.ask("ask", operation="status"))["sim_ns"]
        )
        later = {"fault": "shaft_jam", "parameters": {"start_s": 500}}
        await page.ask("ask", operation="inject", target="m1", given=later)
        told = await page.until(lambda each: isinstance(each, dict) and len(each.get("value", ())) == 2)
        jam_ns, later_ns = (fault["begin_ns"] for fault in told["value"])
        assert later_ns - jam_ns > 500_000_000_000
        await page.ask("ask", operation="clear", given={"number": told["value"][1]["number"]})
        await page.ask("ask", operation="clear", given={"number": number})
        await page.until(lambda each: isinstance(each, dict) and each.get("value") == [])
        bad = await page.ask("ask", operation="run", given={"text": "run: a\nsteps: 5\n"})
        assert (bad["code"], bad["problems"][1]["line"], bad["problems"][1]["column"]) == ("bad_run", 2, 8)

    with_page(tmp_path, use)


def test_a_reload_is_told_and_terminals_of_what_has_gone_are_closed(tmp_path: Path) -> None:
    file = tmp_path / "t.yaml"
    file.write_text(text())

    async def use(bench: Asking) -> None:
        async with page_of(bench) as page:
            await page.ask("open", port="m1")
            changed = json.loads(text())
            del changed["devices"]["m1"]
            file.write_text(json.dumps(changed))
            assert (await page.ask("ask", operation="reload"))["removed"] == ["m1"]
            closed = await page.until(lambda each: isinstance(each, dict) and "closed" in each)
            assert closed["closed"]["terminal"] == 1
            told = (await page.until(lambda each: isinstance(each, dict) and "changed" in each))["changed"]
            assert "m1" not in [device["name"] for device in told["devices"]]

    desk_in(tmp_path, text(), file)(use)


def test_the_program_of_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = block("docs/how-to/web.md", "For programs")

    async def use(bench: Asking) -> None:
        here = program.replace("http://127.0.0.1:8080/", url_of(bench))
        await asyncio.to_thread(exec, compile(here, "web.md", "exec"), {})

    desk_in(tmp_path, text())(use)
    rows = [tuple(map(float, line.split())) for line in capsys.readouterr().out.splitlines()]
    assert len(rows) >= 100
    assert rows[1][0] - rows[0][0] == pytest.approx(1 / 60, abs=2e-6)


ROLES = {
    "guest": {
        "status": True,
        "do reset": False,
        "pin": False,
        "inject": False,
        "reload": False,
        "open": False,
    },
    "ann": {"status": True, "do reset": True, "pin": True, "inject": False, "reload": False, "open": True},
    "boss": {"status": True, "do reset": True, "pin": True, "inject": True, "reload": True, "open": True},
}
GIVEN: dict[str, dict[str, Any]] = {
    "status": {"operation": "status"},
    "do reset": {"operation": "do", "target": "s1", "given": {"name": "reset", "parameters": {}}},
    "pin": {"operation": "pin", "target": "s1", "given": {"pin": "sync", "level": 1}},
    "inject": {"operation": "inject", "target": "m1", "given": {"fault": "shaft_jam", "parameters": {}}},
    "reload": {"operation": "reload"},
}


def test_each_role_may_do_what_it_may(tmp_path: Path) -> None:
    users = tmp_path / "users"
    made = hash_of(PASSWORD, bytes(16))
    users.write_text(f"guest:viewer:{made}\nann:operator:{made}\nboss:admin:{made}\n")
    users.chmod(0o600)

    async def use(bench: Asking) -> None:
        for user, may in ROLES.items():
            async with page_of(bench, user) as page:
                for what, is_allowed in may.items():
                    asked = ("open", {"port": "s1"}) if what == "open" else ("ask", GIVEN[what])
                    answer = await page.ask(asked[0], **asked[1])
                    is_refused = isinstance(answer, dict) and answer.get("code") == "forbidden"
                    assert is_refused is not is_allowed, (user, what, answer)
                assert (await page.ask("watch", what="samples", target="m1", fields=["r"])) == {"watch": 1}

    desk_in(tmp_path, text(users=str(users)))(use)


def test_a_viewer_is_asked_of_every_operation(tmp_path: Path) -> None:
    """No operation of more than a viewer's role gets past the door, whatever it is given."""

    async def use(bench: Asking) -> None:
        viewer = Source("guest", Role.VIEWER)
        for name, operation in bench.desk.describe().operations.items():
            if operation.role > Role.VIEWER:
                with pytest.raises(Exception, match="needs the role"):
                    bench.desk.ask(viewer, name, "", {})

    desk_in(tmp_path, text())(use)
