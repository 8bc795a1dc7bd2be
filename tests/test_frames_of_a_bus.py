"""Frames of a bus that hil does not have, in captures."""

import json
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

from bridges.can.bus.bus_events import BusEvent
from bridges.can.cards.bench_bus import FRAMES
from bridges.web.wire_streams import BusFrames
from hil.cli.captures.capture_run import described
from hil.compose.decoding import Decoder
from hil.live.captures import BACKLOG_BYTES, Capture
from hil.live.core_thread import WallClock
from hil.vocab.wire import FrameKind
from hil.wire.pcapng import LINKTYPES_USER, Interface, interfaces_in, read


class SlowWriter:
    """Writer whose reader takes nothing while ``waiting`` is large."""

    def __init__(self) -> None:
        self.got, self.waiting, self.transport = b"", 0, self

    def write(self, data: bytes) -> None:
        self.got += data

    def is_closing(self) -> bool:
        return False

    def get_write_buffer_size(self) -> int:
        return self.waiting


PEARLS = FrameKind(lambda event: event.data, lambda: vars, LINKTYPES_USER[0], b"lost", "pearls")
"""Frames on a ring."""


def test_a_capture_has_its_frames_and_losses(tmp_path: Path) -> None:
    line = Interface("r", PEARLS.name, 1000, link=PEARLS.link)
    no_bench: Any = None
    writer: Any = SlowWriter()
    capture = Capture([line, Interface("bus0", "sac", 9600)], WallClock(no_bench, 1.0, 0))
    capture.begin(writer)
    for at_ns, waiting in enumerate((0, BACKLOG_BYTES + 1, 0)):
        writer.waiting = waiting
        capture.carried(0, PEARLS, SimpleNamespace(at_ns=at_ns, node="m1", data=b"pearl %d" % at_ns))
    found = list(read(writer.got))
    assert [(each.data, each.comment, each.lost) for each in found] == [
        (b"pearl 0", "m1", 0),
        (b"lost", "the reader was too slow: 1 lost", 1),
        (b"pearl 2", "m1", 0),
    ]
    assert {each.line for each in found} == {line}
    assert interfaces_in(writer.got)[0] == line
    assert described([line]) == "r (pearls, 1000 bit/s)"
    decoder = Decoder()
    assert [item for record in found for item in decoder.feed(record)] == []
    assert "a frame of pearls, which nothing here puts into words" in decoder.left_out.told()
    if tshark := shutil.which("tshark"):
        file = tmp_path / "r.pcapng"
        file.write_bytes(writer.got)
        options = ("-T", "fields", "-e", "frame.encap_type", "-e", "frame.interface_description")
        told = subprocess.run([tshark, "-r", file, *options], capture_output=True, text=True, check=True)
        assert told.stdout == "45\tpearls\n" * 3  # Wireshark's number of USER0


def test_the_page_captures_its_frames() -> None:
    desk: Any = Mock()
    desk.describe.return_value = Mock(segments={}, buses={"r": PEARLS})
    frames = BusFrames(desk, Mock(), 1, "r", {})
    assert interfaces_in(frames.capture("hil")._head) == [Interface("r", "pearls", link=PEARLS.link)]


def test_errors_that_come_again_and_again_are_one_item_of_a_turn() -> None:
    desk: Any = Mock()
    desk.describe.return_value = Mock(segments={}, buses={"can0": FRAMES})
    frames = BusFrames(desk, Mock(), 1, "can0", {})
    for number in range(3000):
        frames.put(BusEvent(number * 1000, number * 1000 + 900, "m1", error="acknowledgement"))
    frames.put(BusEvent(4_000_000, 4_000_100, "m1", state="error-passive"))
    for node in ("m1", "m2", "m2"):
        frames.put(BusEvent(5_000_000, 5_000_100, node, error="stuff"))
    told = json.loads(frames.next_message(0) or "")
    found = [(item["from"], item["text"], item.get("times")) for item in told["items"]]
    assert found == [
        ("m1", "acknowledgement, 3000 times", 3000),
        ("m1", "error-passive", None),
        ("m1", "stuff", None),
        ("m2", "stuff, 2 times", 2),
    ]
    assert told["items"][0]["duration_s"] == 0.0029999
    assert told["lost"] == 0
