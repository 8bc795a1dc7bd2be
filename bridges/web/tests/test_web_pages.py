"""Pages at the door: what they are told, what they watch, and what happens with those that misbehave."""

import asyncio
import gzip
import json
import re
import struct
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack
from fractions import Fraction
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from pages_of_tests import PACKED, Door, Page, PagesDesk, blocks, frame, opened, raw_page

from bridges.web import open_pages, web_bridge, web_client
from bridges.web.page_files import read_page
from bridges.web.streams import MOST_ITEMS
from bridges.web.web_watches import MOST_WIRES
from hil.vocab.desk_protocol import Encoded, Watched
from hil.vocab.operation import Operation, Target
from hil.vocab.verbs import Role, Verb, VerbRefused


def run(use: Callable[[Door], Awaitable[None]], desk: PagesDesk | None = None, **options: Any) -> None:
    async def main() -> None:
        async with opened(desk, **options) as door:
            await use(door)

    asyncio.run(main())


def watching(door: Door, number: int = 0) -> Any:
    return door.desk.watching[number][2]


# ---- the page's files ----


def test_a_page_is_kept_as_it_was_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("<!doctype html>")
    script = b"let a;" * 1000
    (tmp_path / "page.js").write_bytes(script)
    (tmp_path / "build.json").write_text('{"version": "abc"}')
    (tmp_path / "secret.key").write_text("x")
    page = read_page(tmp_path)
    assert page.version == "abc"
    assert page.files.keys() == {"/", "/index.html", "/page.js", "/build.json"}
    assert page.files["/page.js"].content == gzip.decompress(page.files["/page.js"].compressed) == script
    assert page.files["/"].compressed == b""  # a small one goes as it is


@pytest.mark.parametrize("build", ["", "[]", "{}", '{"version": '])
def test_a_folder_without_a_page_says_so(tmp_path: Path, build: str) -> None:
    (tmp_path / "build.json").write_text(build)
    page = read_page(tmp_path)
    assert page.version == ""
    assert b"make web" in page.files["/"].content


def test_files_come_packed_and_only_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    index = "<!doctype html>" * 100
    (tmp_path / "index.html").write_text(index)
    monkeypatch.setattr(web_bridge, "read_page", lambda: read_page(tmp_path))

    async def use(door: Door) -> None:
        session = door.session
        async with session.get(door.url, headers={"Accept-Encoding": "identity"}) as answer:
            assert (await answer.text(), answer.content_type) == (index, "text/html")
            etag = answer.headers["ETag"]
        async with session.get(door.url, headers={"If-None-Match": etag}) as answer:
            assert (answer.status, await answer.read()) == (304, b"")
        async with session.head(door.url, headers={"Accept-Encoding": "gzip"}) as answer:
            assert answer.headers["Content-Encoding"] == "gzip"
            assert int(answer.headers["Content-Length"]) < len(index) / 10
        async with session.get(door.url, headers={"Accept-Encoding": "gzip"}) as answer:
            assert await answer.text() == index

    run(use)


# ---- hello, ask ----


def test_a_page_is_told_the_bench_first() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            assert (page.hello["bench"], page.hello["user"], page.hello["role"]) == ("check", "web", "admin")
            one, other = page.hello["devices"]
            assert (one["name"], one["is_seen"], other["name"], other["is_real"]) == ("m1", True, "m2", True)
            assert [field["name"] for field in one["fields"]] == ["at_ns", "r", "n", "x"]
            pin = one["verbs"]["pin"]["parameters"]
            assert (pin[0]["type"], pin[1]["type"]) == ("text", "whole")
            kinds = {kind["name"]: kind for kind in page.hello["fault_kinds"]}
            assert kinds["phase_open"]["parameters"][0]["choices"] == ["A", "B"]

    run(use)


def test_what_is_asked_is_answered_or_refused() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            done = await page.ask(
                "ask", operation="do", target="m1", given={"name": "reset", "parameters": {}}
            )
            assert done == {"effective_at_ns": 5_000_000_000}
            assert (await page.ask("ask", operation="do", target="m9"))["code"] == "no_device"
            assert (await page.ask("ask", operation="reset", target=5))["code"] == "bad_parameter"
            assert (await page.ask("ask"))["message"] == "operation: this one is missing"
            assert "there are ask, watch" in (await page.ask("jump"))["message"]
        status = door.bridge.status()
        assert (status["commands"], status["rejected"]) == (1, 4)

    run(use)


def test_what_takes_its_time_holds_up_nothing() -> None:
    class SlowDesk(PagesDesk):
        may_end = asyncio.Event()

        def ask(self, source: Any, operation: str, target: str, given: Any) -> Any:
            async def later() -> dict[str, int]:
                await self.may_end.wait()
                if operation == "fail":
                    raise VerbRefused("not_now", "later")
                return {"done": 1}

            return later() if operation in ("wait", "fail") else super().ask(source, operation, target, given)

    async def use(door: Door) -> None:
        async with door.page() as page:
            for number in range(100, 100 + web_client.MOST_TASKS):
                operation = "fail" if number == 100 else "wait"
                await page.socket.send_json({"id": number, "do": "ask", "operation": operation})
            assert (await page.ask("ask", operation="wait"))["code"] == "busy"
            SlowDesk.may_end.set()
            assert await page.answer(100) == {"code": "not_now", "message": "later"}
            assert await page.answer(101) == {"done": 1}

    run(use, SlowDesk())


def test_a_fault_of_our_own_is_one_requests(caplog: pytest.LogCaptureFixture) -> None:
    class BrokenDesk(PagesDesk):
        def ask(self, source: Any, operation: str, target: str, given: Any) -> Any:
            if operation == "break":
                raise RuntimeError("broken")
            return super().ask(source, operation, target, given)

    async def use(door: Door) -> None:
        async with door.page() as page:
            assert (await page.ask("ask", operation="break"))["code"] == "failed"
            assert await page.ask("ask", operation="faults") == []

    run(use, BrokenDesk())
    assert "could not be carried out" in caplog.text


# ---- watches ----


def test_samples_come_as_they_were_asked_for() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            given = {"what": "samples", "target": "m1", "fields": ["x", "r"], "rate_Hz": 30}
            assert await page.ask("watch", **given) == {"watch": 1}
            assert watching(door).interval_ns == Fraction(10**9, 30)
            watching(door).waiting = [
                PACKED.pack(1_500_000_000, 0.5, 7, 2.25),
                PACKED.pack(2 * 10**9, 1.5, 8, -1.0),
            ]
            (block,) = blocks(await page.until(lambda each: isinstance(each, bytes)))
            assert block == (1, 0, [(1.5, 2.25, 0.5), (2.0, -1.0, 1.5)])
            assert watching(door).points == 1
            assert await page.ask("unwatch", watch=1) == await page.ask("unwatch", watch=1) == {}
            assert door.desk.watching == []

    run(use)


def test_extremes_are_asked_for_and_the_time_is_a_field() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            given = {
                "what": "samples",
                "target": "m1",
                "fields": ["at_ns", "x", "x"],
                "rate_Hz": 60,
                "points": 12,
            }
            assert await page.ask("watch", **given) == {"watch": 1}
            assert (watching(door).interval_ns, watching(door).points) == (Fraction(10**9, 60), 12)
            watching(door).waiting = [PACKED.pack(1_500_000_000, 0.5, 7, 2.25)]
            (block,) = blocks(await page.until(lambda each: isinstance(each, bytes)))
            assert block == (1, 0, [(1.5, 1.5e9, 2.25, 2.25)])

    run(use)


def test_all_samples_of_a_turn_are_one_message() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            for _ in range(3):
                await page.ask("watch", what="samples", target="m1", fields=["n"])
            watching(door, 2).waiting = [PACKED.pack(9, 0, 9, 0)]
            await page.until(lambda each: isinstance(each, bytes))  # the turn in which the last one joins
            for number in range(3):
                watching(door, number).waiting = [PACKED.pack(number, 0, number, 0)]
            found = blocks(await page.until(lambda each: isinstance(each, bytes)))
            assert [(block.watch, block.rows[0][1]) for block in found] == [(1, 0.0), (2, 1.0), (3, 2.0)]

    run(use)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"what": "jumps"}, "there is no 'jumps'"),
        ({"what": "samples", "target": "m1"}, "fields: "),
        (
            {"what": "samples", "target": "m1", "fields": ["y"], "rate_Hz": 1},
            "m1 has no field 'y'; it has at_ns, r, n, x",
        ),
        ({"what": "samples", "target": "m1", "fields": ["x"] * 65}, "fields: write a list of 1 to 64"),
        ({"what": "samples", "target": "m1", "fields": ["x"], "rate_Hz": 0}, "rate_Hz: write 0.01 to 100"),
        ({"what": "samples", "target": "m1", "fields": ["x"], "rate_Hz": 101}, "rate_Hz: write 0.01 to 100"),
        ({"what": "samples", "target": "m1", "fields": ["x"], "rate_Hz": 60}, "up to 100 samples a second"),
        (
            {"what": "samples", "target": "m1", "fields": ["x"], "rate_Hz": 30, "points": 2},
            "up to 100 samples a second",
        ),
        ({"what": "samples", "target": "m1", "fields": ["x"], "points": 1.5}, "points: write a whole number"),
        ({"what": "samples", "target": "m2", "fields": ["y"], "rate_Hz": 1}, "m2 has no field 'y'"),
        ({"what": "status", "rate_Hz": 5}, "rate_Hz: write 0.01 to 4"),
        ({"what": "packets", "target": "bus0"}, "there is no segment 'bus0'; there are none"),
        ({"target": "m1"}, "what: this one is missing"),
    ],
)
def test_what_cannot_be_watched_is_refused(given: dict[str, Any], why: str) -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("watch", what="samples", target="m1", fields=["x"], rate_Hz=50)
            assert why in (await page.ask("watch", **given))["message"]
            assert len(door.desk.watching) == 1

    run(use, samples_per_s=100)


def test_status_is_read_once_for_all_pages_and_told_when_it_changes() -> None:
    desk = PagesDesk()
    told = {"number": 1}
    desk._answers = {**desk._answers, "status": told}

    async def use(door: Door) -> None:
        async with AsyncExitStack() as stack:
            pages = [await stack.enter_async_context(door.page()) for _ in range(10)]
            for page in pages:
                await page.ask("watch", what="status", rate_Hz=4)
            for page in pages:
                assert (await page.until(lambda each: "value" in each))["value"] == {"number": 1}
            told["number"] = 2
            for page in pages:
                assert (await page.until(lambda each: "value" in each))["value"] == {"number": 2}
                assert page.pushed == []
        assert sum(operation == "status" for _, operation, _ in desk.asked) < 10

    run(use, desk)


def test_progress_of_runs_is_the_latest_of_each() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("watch", what="runs")
            for step in range(3):
                for name in ("<script>alert(1)</script>", 'a "b" \\ \u2028\x07é'):
                    watching(door).call({"run": name, "step": step})
            items = (await page.until(lambda each: "items" in each))["items"]
            assert {item["run"]: item["step"] for item in items} == {
                "<script>alert(1)</script>": 2,
                'a "b" \\ \u2028\x07é': 2,
            }

    run(use)


def test_bytes_at_a_port_come_in_their_order_and_the_oldest_are_lost() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("watch", what="bytes", target="m1")
            assert door.desk.watching[0][:2] == (Watched.BYTES, "m1")
            for number in range(MOST_ITEMS + 5):
                watching(door).call("board", struct.pack("<I", number))
            items: list[Any] = []
            while len(items) < MOST_ITEMS:
                pushed = await page.until(lambda each: "items" in each)
                items += pushed["items"]
                assert pushed["lost"] == 5
            numbers = [struct.unpack("<I", bytes.fromhex(item["hex"]))[0] for item in items]
            assert numbers == list(range(5, MOST_ITEMS + 5))

    run(use)


def test_only_so_many_wires_are_watched_at_a_time() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            for _ in range(MOST_WIRES):
                assert "watch" in await page.ask("watch", what="bytes", target="m1")
            assert (await page.ask("watch", what="bytes", target="m1"))["code"] == "not_now"
            await page.ask("unwatch", watch=1)
            assert "watch" in await page.ask("watch", what="bytes", target="m1")

    run(use)


# ---- those who come, go and misbehave ----


def test_a_reload_is_told_to_all_and_watches_of_what_changed_end() -> None:
    async def use(door: Door) -> None:
        async with door.page() as one, door.page() as other:
            await one.ask("watch", what="samples", target="m1", fields=["x"])
            await one.ask("watch", what="status")
            door.desk.devices["m3"] = door.desk.devices.pop("m2")
            await door.bridge.devices_changed(["m1", "m2", "m3"])
            closed = (await one.until(lambda each: "closed" in each))["closed"]
            assert closed == {"watch": 1, "why": "m1 was changed"}
            for page in (one, other):
                changed = (await page.until(lambda each: "changed" in each))["changed"]
                assert changed.keys() == page.hello.keys()
                assert [device["name"] for device in changed["devices"]] == ["m1", "m3"]
            assert door.desk.watching == []

    run(use)


def test_a_page_that_leaves_leaves_nothing() -> None:
    async def use(door: Door) -> None:
        for _ in range(3):
            async with door.page() as page:
                await page.ask("watch", what="samples", target="m1", fields=["x"])
                await page.ask("watch", what="runs")
            await door.until(lambda: not door.desk.watching and door.bridge.status()["links"] == 0)

    run(use)


def test_fifty_pages_get_all_their_samples() -> None:
    async def use(door: Door) -> None:
        async with AsyncExitStack() as stack:
            pages = [await stack.enter_async_context(door.page()) for _ in range(50)]
            for page in pages:
                await page.ask("watch", what="samples", target="m1", fields=["n"])
            for turn in range(3):
                for number in range(50):
                    watching(door, number).waiting = [PACKED.pack(turn, 0, number, 0)]
                for number, page in enumerate(pages):
                    (block,) = blocks(await page.until(lambda each: isinstance(each, bytes)))
                    assert (block.lost, block.rows) == (0, [(turn / 1e9, float(number))])

    run(use)


def test_only_so_many_pages_are_open() -> None:
    async def use(door: Door) -> None:
        async with door.page(), door.page():
            with pytest.raises(aiohttp.WSServerHandshakeError, match="503"):
                await door.session.ws_connect(f"{door.url}ws", protocols=("hil.v1",))
        await door.until(lambda: door.bridge.status()["links"] == 0)
        async with door.page():
            pass

    run(use, sockets=2)


def test_who_does_not_read_loses_what_comes_then_the_socket(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web_client, "STALLED_S", 0.5)

    async def use(door: Door) -> None:
        deaf = await raw_page(door.url)
        loop = asyncio.get_running_loop()
        watch = {"id": 1, "do": "watch", "what": "samples", "target": "m1", "fields": ["x", "r", "n"]}
        await loop.sock_sendall(deaf, frame(json.dumps(watch)))
        await door.until(lambda: bool(door.desk.watching))
        async with door.page() as page:
            await page.ask("watch", what="status")
            watching(door).waiting = []
            door.desk.endless = [PACKED.pack(0, 0, 0, 0)] * 2000
            await door.until(lambda: door.bridge.status()["dropped"] > 0)
            transports = [client._transport for client in door.bridge._pages._clients]  # type: ignore[attr-defined]
            assert max(each.get_write_buffer_size() for each in transports) < 1 << 20
            assert await page.ask("ask", operation="faults") == []
            await door.until(lambda: door.bridge.status()["links"] == 1)
            assert door.bridge.status()["dropped"] > 2000
            assert not [what for what, _, _ in door.desk.watching if what is Watched.SAMPLES]
        deaf.close()

    run(use)


def test_a_stopped_page_goes_while_its_computer_still_takes_what_comes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert 1.5 * open_pages.HEARTBEAT_S <= 10  # as docs/how-to/web.md says
    monkeypatch.setattr(open_pages, "HEARTBEAT_S", 0.4)

    async def use(door: Door) -> None:
        async with door.page(autoping=False), door.page() as other:
            reading = asyncio.create_task(other.until(lambda message: False))
            await door.until(lambda: door.bridge.status()["links"] == 1)
            await asyncio.sleep(2 * open_pages.HEARTBEAT_S)  # the one that answers stays
            assert door.bridge.status()["links"] == 1
            reading.cancel()

    run(use)


def test_a_message_that_is_too_long_ends_its_page_alone() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page, door.page() as other:
            await page.socket.send_str("x" * 1_100_000)
            assert await page.closed() == 1009
            assert await other.ask("ask", operation="faults", given={"text": "x" * 1_000_000}) == []

    run(use)


def test_a_message_is_as_long_as_the_page_is_told() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            assert page.hello["message_bytes"] == 2048
            for size, is_taken in ((2048, True), (2049, False)):
                text = json.dumps({"id": size, "do": "close", "terminal": 1}).ljust(size)
                await page.socket.send_str(text)
                if is_taken:
                    assert await page.answer(size) == {}
            assert await page.closed() == 1009

    run(use, message_kb=2)


@pytest.mark.parametrize("version", ["7", "8", "12", "", "13, 8"])
def test_drafts_of_websockets_are_refused(version: str) -> None:
    async def use(door: Door) -> None:
        headers = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": version}
        headers |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Protocol": "hil.v1"}
        async with door.session.get(f"{door.url}ws", headers=headers) as answer:
            assert answer.status == 426
            assert answer.headers["Sec-WebSocket-Version"] == "13"

    run(use)


def test_a_long_answer_is_made_once_for_all_and_waits_in_small_pieces() -> None:
    part = b'"' + b"a" * (8 << 20) + b'"'
    desk = PagesDesk({"drawing": Encoded((b'{"text":', part, b"}"))})

    async def use(door: Door) -> None:
        slow = await raw_page(door.url)
        loop = asyncio.get_running_loop()
        ask = json.dumps({"id": 1, "do": "ask", "operation": "drawing"})
        for _ in range(20):
            await loop.sock_sendall(slow, frame(ask))
        async with door.page() as page:
            assert await page.ask("ask", operation="drawing") == {"text": "a" * (8 << 20)}
        (connection,) = door.bridge._visits  # type: ignore[attr-defined]
        assert connection.transport.get_write_buffer_size() < 256 << 10
        slow.close()

    run(use, desk)


def test_events_are_told_with_those_of_before_and_again_when_others_join_them() -> None:
    def event(number: int, count: int = 1) -> dict[str, Any]:
        return {"number": number, "revision": number, "count": count, "kind": "verbs", "text": "enable"}

    desk = PagesDesk({"events": {"events": [event(7)], "left_out": 6, "revision": 7}})

    async def use(door: Door) -> None:
        async with door.page() as page:
            number = (await page.ask("watch", what="events"))["watch"]
            told = await page.until(lambda each: isinstance(each, dict) and each.get("watch") == number)
            assert (told["items"], told["lost"]) == ([event(7)], 6)
            for count in (1, 2, 3):
                watching(door).call(event(8, count))
            seen: list[Any] = []
            while not seen or seen[-1]["count"] < 3:
                more = await page.until(lambda each: isinstance(each, dict) and each.get("watch") == number)
                seen += more["items"]
            assert {each["number"] for each in seen} == {8}

    run(use, desk)


def test_what_came_too_late_is_an_event() -> None:
    noted: list[tuple[str, str, str]] = []

    class Noting(PagesDesk):
        def note_refusal(self, source: Any, operation: str, target: str, given: Any, refusal: Any) -> None:
            noted.append((operation, target, refusal.code))

    async def use(door: Door) -> None:
        async with door.page() as page:
            given = {"name": "enable", "parameters": {}}
            late = await page.ask("ask", operation="do", target="m1", given=given, until_ms=1)
            assert late["code"] == "not_now"
            assert (await page.ask("watch", what="faults", until_ms=1))["code"] == "not_now"

    run(use, Noting())
    assert noted == [("do", "m1", "not_now")]


def test_what_a_page_waits_for_ends_with_it() -> None:
    begun, ended = asyncio.Event(), asyncio.Event()

    async def planning() -> None:
        begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()

    async def use(door: Door) -> None:
        never = planning()  # one that is cancelled before it begins, too: it warns if nobody awaits it
        door.desk._answers = {"drawing": planning(), "run": never}
        async with door.page() as page:
            await page.socket.send_json({"id": 1, "do": "ask", "operation": "drawing"})
            await begun.wait()
            await page.socket.send_json({"id": 2, "do": "ask", "operation": "run"})
        await asyncio.wait_for(ended.wait(), 5)
        await door.until(lambda: door.bridge.status()["links"] == 0)

    run(use)


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        (frame(b"\xff\xfe"), 1007),
        (b"\xff" * 100, 1002),
        (frame(b"", opcode=3), 1002),
        (b"\x81\x05hello", 1002),  # without a mask
        (frame(struct.pack(">H", 1006), opcode=8), 1002),
        (b"\x09" + frame(b"")[1:], 1002),  # a ping in fragments
        (frame(bytes(126), opcode=9), 1002),
        (bytes([0xC1]) + frame(b"")[1:], 1002),  # a reserved bit
    ],
)
def test_what_is_no_message_ends_that_page_alone(sent: bytes, code: int) -> None:
    async def use(door: Door) -> None:
        bad, loop = await raw_page(door.url), asyncio.get_running_loop()
        async with door.page() as page:
            await loop.sock_sendall(bad, sent)
            await door.until(lambda: door.bridge.status()["links"] == 1)
            assert await page.ask("ask", operation="faults") == []
        data = b""
        while more := await loop.sock_recv(bad, 65536):
            data += more
        assert b"\x88" in data
        assert struct.pack(">H", code) in data[data.rindex(b"\x88") :]
        bad.close()

    run(use)


@pytest.mark.parametrize(
    "text", ["", "nonsense", "[1]", '{"id": 1}', "[" * 30_000, '{"id": "<b>", "do": "ask"}']
)
def test_garbage_is_answered_and_nothing_ends(text: str) -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.socket.send_str(text)
            refused = await page.until(lambda each: "error" in each)
            assert refused["error"]["code"] == "bad_request"
            await page.socket.send_bytes(b"\x07\x00")
            assert (await page.until(lambda each: "error" in each))["id"] is None
            assert await page.ask("ask", operation="faults") == []

    run(use)


def test_half_a_frame_and_half_a_request_hold_up_nobody() -> None:
    async def use(door: Door) -> None:
        half, loop = await raw_page(door.url), asyncio.get_running_loop()
        await loop.sock_sendall(half, frame('{"id": 1, "do": "ask", "operation": "faults"}')[:20])
        _, writer = await asyncio.open_connection("127.0.0.1", int(door.url[:-1].rpartition(":")[2]))
        writer.write(b"GET / HT")
        async with door.page() as page:
            assert await page.ask("ask", operation="faults") == []
            await loop.sock_sendall(half, frame('{"id": 1, "do": "ask", "operation": "faults"}')[20:])
            await door.until(lambda: door.bridge.status()["commands"] == 2)
        writer.transport.abort()
        half.close()

    run(use)


def test_messages_wait_where_too_many_come() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            began_s = asyncio.get_running_loop().time()
            for _ in range(60):
                await page.ask("ask", operation="faults")
            assert asyncio.get_running_loop().time() - began_s > 0.15  # 50 at once, then 50 a second

    run(use, messages_per_s=50)


def test_pages_are_told_that_the_bench_ends() -> None:
    async def main() -> None:
        async with AsyncExitStack() as stack, opened() as door:
            page = await stack.enter_async_context(door.page())
            closing = asyncio.create_task(page.closed())
            await asyncio.sleep(0)
            await door.bridge.close()
            assert await closing == 1001

    asyncio.run(main())


def test_a_verb_that_waits_does_not_move_what_another_page_has_stopped() -> None:
    desk = PagesDesk()
    desk._operations = {"do": Operation("do", Target.MEMBER, "", role=Role.VIEWER, answer=dict)}
    desk.devices["m1"].verbs["stop"], desk.devices["m1"].verbs["wave"] = Verb("stop", ""), Verb("wave", "")

    async def use(door: Door) -> None:
        turns = door.bridge._pages._around.turns  # type: ignore[attr-defined]
        async with door.page() as mover, door.page() as stopper:
            while turns.spend():
                pass
            turns.note(None, 60.0)  # whoever comes now waits
            moving = asyncio.create_task(
                mover.ask("ask", operation="do", target="m1", given={"name": "wave", "parameters": {}})
            )
            await door.until(lambda: bool(turns._sleepers))
            stop = await stopper.ask(
                "ask", operation="do", target="m1", given={"name": "stop", "parameters": {}}
            )
            assert "effective_at_ns" in stop
            turns._over_s = 0.0
            turns._go_on()
            assert (await moving)["code"] == "not_now"
            again = await mover.ask(
                "ask", operation="do", target="m1", given={"name": "wave", "parameters": {}}
            )
            assert "effective_at_ns" in again
        assert desk.done == [("m1", "stop"), ("m1", "wave")]

    run(use, desk)


# ---- deadlines ----


async def clock_ms(page: Page) -> float:
    """Time of the door's clock, as a page is told it next."""
    told: float = (await page.until(lambda each: isinstance(each, dict) and "value" in each))["value"]
    return told


def test_the_clock_is_told_although_nothing_else_is_new() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("watch", what="clock", rate_Hz=2)
            await clock_ms(page)  # comes with the answer, out of step
            first, second = await clock_ms(page), await clock_ms(page)
            assert first + 300 < second <= asyncio.get_running_loop().time() * 1000 + 1
            assert "rate_Hz: write" in (await page.ask("watch", what="clock", rate_Hz=100))["message"]

    run(use)


def test_what_would_begin_after_its_deadline_is_refused() -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("watch", what="clock")
            now_ms = await clock_ms(page)
            reset = {"operation": "do", "target": "m1", "given": {"name": "reset", "parameters": {}}}
            assert "effective_at_ns" in await page.ask("ask", until_ms=now_ms + 60_000, **reset)
            refused = await page.ask("ask", until_ms=now_ms - 11_000, **reset)
            assert refused["code"] == "not_now"
            assert re.match(r"its turn came 11\.\d s after its deadline, so it was not", refused["message"])
            assert door.desk.done == [("m1", "reset")]
            assert "until_ms: write" in (await page.ask("ask", until_ms="soon", **reset))["message"]

    run(use)
