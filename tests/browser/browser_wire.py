"""The wire view in a browser: packets as they pass, a collision, filter, pause, sending, a capture."""

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_pages import PHONE, Bench, companion_bench, fits, served, violations
from e2e_support import config, until
from playwright.sync_api import Browser, Page, expect

SEGMENTS = {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "pty"}}}}


@pytest.fixture
def bench(chromium: Browser) -> Iterator[Bench]:
    yield from companion_bench(chromium, 1, segments=SEGMENTS)


@pytest.fixture
def page(bench: Bench) -> Page:
    page = bench.open("wire/bus0")
    expect(page.get_by_text("0 shown of 0")).to_be_visible()
    bench.server.ready("s1").ready("s2")
    return page


def send(page: Page, text: str, to: str = "85") -> None:
    page.get_by_label("to", exact=True).fill(to)
    page.get_by_label("Command", exact=True).fill(text)
    page.get_by_role("button", name="Send", exact=True).click()


def test_packets_are_shown_filtered_paused_and_exported(page: Page, bench: Bench) -> None:
    rows = page.locator(".packet-rows .packet")
    send(page, "m300", to="0")
    expect(rows).to_have_count(1)
    expect(rows.first).to_contain_text(re.compile(r"1\s*all\s*bus0\.master\s*m300"))
    # Both boards have the address 85 from the factory: their answers collide.
    send(page, "m400")
    bad = page.locator(".packet-rows .packet.is-bad")
    expect(bad.first).to_contain_text("collision of s1.network and s2.network")
    expect(page.get_by_role("table", name="What was wrong")).to_contain_text("collision")
    page.get_by_label("Filter the packets").fill("m400 -error")
    expect(rows).to_have_count(1)
    page.get_by_label("Filter the packets").fill("")
    page.get_by_role("button", name="Pause").click()
    send(page, "m500", to="0")
    expect(page.get_by_text("1 since the pause")).to_be_visible()
    expect(page.get_by_text("m500", exact=False).and_(rows)).to_have_count(0)
    page.get_by_role("button", name="Go on").click()
    expect(rows.last).to_contain_text("m500")
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Export pcapng").click()
    capture = str(Path(waiting.value.path()))
    told = bench.place.hil("decode", capture)
    assert "1 -> all m300" in told
    assert "m500" in told
    if shutil.which("tshark"):
        dump = ["tshark", "-r", capture, "-T", "fields", "-e", "frame.len"]
        read = subprocess.run(dump, capture_output=True, text=True, timeout=60)
        assert len(read.stdout.split()) == told.count("\n")


def test_the_time_line_and_the_load_follow(page: Page) -> None:
    for number in range(5):
        send(page, f"m{number + 1}00", to="0")
    expect(page.get_by_role("img", name="Time line of 1.000 s up to now")).to_be_visible()
    expect(page.get_by_role("meter", name="Load of the last second")).to_be_visible()
    expect(page.locator(".figures").get_by_text("5", exact=True)).to_be_visible()


def test_the_time_line_goes_back_and_zooms(page: Page) -> None:
    send(page, "m300", to="0")
    expect(page.locator(".packet-rows .packet")).to_have_count(1)
    line = page.get_by_role("img", name="Time line of")
    line.press("ArrowLeft")
    expect(line).to_have_accessible_name(re.compile(r"^Time line of 1\.000 s up to \d"))
    line.press("+")
    expect(line).to_have_accessible_name(re.compile(r"^Time line of 500\.0 ms up to \d"))
    line.press("End")
    page.get_by_role("button", name="Last second").click()
    expect(line).to_have_accessible_name(re.compile(r"^Time line of 1\.000 s up to now"))


def test_a_wire_that_is_not_there(page: Page, bench: Bench) -> None:
    page.goto(f"{bench.url}#/wire/nosuch")
    expect(page.get_by_text("There is no wire “nosuch”. This is bus0.")).to_be_visible()


def test_bytes_that_cannot_be_sent_are_told(page: Page) -> None:
    page.get_by_role("combobox", name="Send").select_option("bytes as they are")
    page.get_by_label("Bytes, hexadecimal").fill("02 5")
    expect(page.get_by_text("a byte has two digits; one is missing")).to_be_visible()
    page.get_by_label("Bytes, hexadecimal").fill("02 56 01")
    page.get_by_role("button", name="Send", exact=True).click()
    # It is no packet yet, and is shown as soon as the line is silent.
    bad = page.locator(".packet-rows .packet.is-bad")
    expect(bad).to_contain_text("unfinished")
    expect(bad).to_contain_text("bus0.master")
    page.get_by_label("Bytes, hexadecimal").fill("6d 39 03 00")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(bad).to_have_count(0)
    expect(page.locator(".packet-rows .packet")).to_have_count(1)
    expect(page.locator(".packet-rows .packet")).to_contain_text(re.compile(r"1\s*86\s*bus0\.master\s*m9"))


def test_a_phone(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    fits(page, 390)


MARKUP = b"<img src=x onerror=alert(1)>"


def test_what_is_strange_is_shown_and_not_carried_out(page: Page, bench: Bench) -> None:
    dialogs: list[str] = []
    terminal = bench.open("companion/s2")
    for each in (page, terminal):
        each.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
    expect(terminal.get_by_text("as in the board")).to_be_visible()
    page.get_by_role("combobox", name="Send").select_option("bytes as they are")
    # Text for all boards: a page's markup, an escape sequence, bytes that are no UTF-8.
    text = b" " + MARKUP + b"\x1b[31m\xff\xc3("
    page.get_by_label("Bytes, hexadecimal").fill((b"\2\0\1" + text + b"\3\0").hex())
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator(".packet-rows .packet")).to_contain_text(MARKUP.decode())
    page.locator(".packet-rows .packet").first.click()
    expect(page.get_by_role("region", name="The chosen packet")).to_contain_text(MARKUP.decode())
    page.get_by_label("Filter the packets").fill("<img")
    expect(page.locator(".packet-rows .packet")).to_have_count(1)
    incoming = terminal.get_by_role("log", name="Incoming")
    expect(incoming).to_contain_text(MARKUP.decode() + "\\x1b[31mÿÃ(")
    assert [each.locator("img").count() for each in (page, terminal)] == [0, 0]
    assert dialogs == []


def test_modbus_and_can_are_told_in_their_words(chromium: Browser) -> None:
    devices = {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}}
    line = {"modbus": {"units": {"m1": 1, "s1": 2}}, "baud": 19200, "taps": {"master": {"port": "pty"}}}
    bus = {"bit_rate": 1_000_000, "nodes": {"m1": {"id": 5}}, "taps": {"slcan0": {"port": "pty"}}}
    bench = json.loads(config(speed=1, devices=devices, segments={"bus0": line}, can={"can0": bus}))
    with served(chromium, bench) as served_bench:
        served_bench.server.ready("m1").ready("s1")
        page = served_bench.open("wire/bus0")
        rows = page.locator(".packet-rows .packet")
        page.get_by_label("Bytes, hexadecimal").fill("02 03 00 00 00 02")
        page.get_by_role("button", name="Send", exact=True).click()
        expect(rows).to_have_count(2)
        expect(rows.first).to_contain_text("read holding registers 0 to 1")
        expect(rows.first).to_contain_text("bus0.master")
        page.get_by_role("combobox", name="Wire").select_option("can0")
        answer = rows.filter(has_text="SDO from 5: 1000h Device type is 00020192h")
        # The page sends as a node of its own, which acknowledges too.
        page.get_by_role("textbox", name="Identifier").fill("605")
        page.get_by_label("Data, hexadecimal").fill("40 00 10 00 00 00 00 00 00")
        expect(page.get_by_text("a frame has at most 8 bytes, this has 9")).to_be_visible()
        page.get_by_label("Data, hexadecimal").fill("40 00 10 00 00 00 00 00")

        def ask() -> int:
            page.get_by_role("button", name="Send", exact=True).click()
            page.wait_for_timeout(300)  # the page watches the bus only from some time on
            return answer.count()

        until(ask, "the drive's answer")
        expect(answer.last).to_contain_text("m1.canopen")
        with page.expect_download() as waiting:
            page.get_by_role("button", name="Export pcapng").click()
        told = served_bench.place.hil("decode", str(Path(waiting.value.path())))
        assert "SDO from 5: 1000h Device type" in told
        expect(page.get_by_role("table", name="Controllers on the bus")).to_contain_text("can0.page")
        answer.last.click()
        fields = page.get_by_role("list", name="Fields of the packet")
        expect(fields).to_contain_text("object 1000h Device type")
        fields.get_by_role("button", name="value 00020192h").hover()
        marked = re.compile("is-marked")
        expect(page.get_by_role("button", name="Byte 4: 92")).to_have_class(marked)
        expect(page.get_by_role("button", name="Byte 3: 00")).not_to_have_class(marked)
        page.get_by_role("button", name="Byte 1: 00").focus()
        expect(fields.get_by_role("button", name="index 1000h")).to_have_class(marked)
        page.get_by_role("button", name="Follow this conversation").click()
        expect(page.get_by_label("Filter the packets")).to_have_value("sdo:5")
        expect(
            page.get_by_role("region", name="By identifier").get_by_role("row").filter(has_text="605")
        ).to_contain_text("µs")
        page.get_by_role("button", name="Take can0.page off").click()
        expect(page.get_by_role("button", name="Take can0.page off")).to_have_count(0)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_in_the_way_of_anybody(bench: Bench, scheme: str) -> None:
    page = bench.open("wire/bus0", color_scheme=scheme)
    bench.server.ready("s1").ready("s2")
    send(page, "m300")
    expect(page.locator(".packet-rows .packet.is-bad").first).to_be_visible()
    page.get_by_role("grid", name="Packets").press("ArrowUp")
    expect(page.get_by_role("region", name="The chosen packet")).to_be_visible()
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    assert violations(page) == []
