"""Channels of a running bench's CAN bus: python-can in another process, another bench, captures, replay."""

import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import can
import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, config, free_port, refused, reload, until

GROUP = "239.74.163.2"
NODE = "can0.udp_multicast"
TSHARK = pytest.mark.skipif(not shutil.which("tshark"), reason="needs tshark")


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def port() -> int:
    return free_port()


def bench(node_id: int, port: int) -> dict[str, Any]:
    bus = {"bit_rate": 1_000_000, "nodes": {"m1": node_id}, "taps": {"a": {}}}
    channel = {"interface": "udp_multicast", "channel": GROUP, "port": port}
    return {"devices": {"m1": {}}, "can": {"can0": bus}, "bridges": {"can": {"channels": {"can0": channel}}}}


@pytest.fixture(scope="module")
def server(place: Place, port: int) -> Server:
    return place.serve(config(**bench(5, port)), "--log", str(place.folder / "inputs.log")).started()


@pytest.fixture
def outside(server: Server, port: int) -> Iterator[can.BusABC]:
    with can.Bus(interface="udp_multicast", channel=GROUP, port=port) as bus:
        yield bus


def message(text: str) -> can.Message:
    identifier, _, rest = text.partition("#")
    is_remote = rest.startswith("R")
    return can.Message(
        arbitration_id=int(identifier, 16),
        is_extended_id=len(identifier) == 8,
        is_remote_frame=is_remote,
        dlc=int(rest[1:] or 0) if is_remote else None,
        data=None if is_remote else bytes.fromhex(rest),
    )


def expect(bus: can.BusABC, can_id: int) -> can.Message:
    """Next message with an identifier, of others."""

    def found() -> can.Message | None:
        while heard := bus.recv(0):
            if heard.arbitration_id == can_id:
                return heard
        return None

    return until(found, f"a message {can_id:03X}")  # type: ignore[return-value]


def channel(server: Server) -> dict[str, Any]:
    row: dict[str, Any] = server.ask("status")["bridges"]["can"]["channels"][0]
    return row


@contextmanager
def beside(server: Server) -> Iterator[can.BusABC]:
    """A program at the bus's tap, once it is on the bus."""
    port = next(row["port"] for row in server.ask("list")["taps"] if row["tap"] == "can0.a")
    with can.Bus(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0) as bus:
        until(lambda: server.ask("buses")[0]["nodes"]["can0.a"]["state"] == "error-active", "the tap")
        yield bus


def test_a_program_and_the_bus_hear_each_other(server: Server, outside: can.BusABC) -> None:
    with beside(server) as here:
        for text in ("123#0011", "1ABCDEF0#0102030405060708", "123#R4", "7FF#"):
            outside.send(message(text))
            heard = expect(here, int(text.partition("#")[0], 16))
            assert (heard.is_extended_id, heard.is_remote_frame) == (
                len(text.split("#")[0]) == 8,
                "R" in text,
            )
            assert heard.dlc == message(text).dlc
        here.send(message("321#AABB"))
        assert expect(outside, 0x321).data == b"\xaa\xbb"
        outside.send(message("000#8105"))  # NMT: reset node 5
        assert expect(outside, 0x705).data == b"\0"


def test_frames_of_a_program_go_out_in_its_order_whatever_their_urgency(
    place: Place, server: Server, outside: can.BusABC
) -> None:
    path = place.folder / "order.log"
    with Capturing(place, "can0", str(path)):
        numbers = [0x600, 0x80, 0x500, 0x100] * 50
        for number in numbers:
            outside.send(can.Message(arbitration_id=number, data=b"ab", is_extended_id=False))
        until(lambda: path.read_text().count("#6162\n") == len(numbers), "all frames")
    with can.LogReader(path) as reader:
        heard = [each for each in reader if each.data == b"ab"]
    assert [each.arbitration_id for each in heard] == numbers
    # Start to end of 11 bit identifiers with two bytes: 63 to 74 bits with the space behind.
    gaps_s = [after.timestamp - before.timestamp for before, after in pairwise(heard)]
    assert min(gaps_s) >= 62e-6


class Capturing:
    """A capture while it is in the block."""

    def __init__(self, place: Place, source: str, path: str) -> None:
        self._path = path
        self._command = [HIL, "capture", source, "-w", path, "--runtime-dir", str(place.runtime)]
        self._watches = lambda: True

    def __enter__(self) -> None:
        import os

        self._process = subprocess.Popen(self._command)
        until(lambda: os.path.exists(self._path), "the capture's file")
        time.sleep(0.3)  # a log of frames has no header to wait for

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait(PATIENCE_S)


def test_what_is_no_frame_is_counted_and_changes_nothing(
    server: Server, outside: can.BusABC, port: int
) -> None:
    before = channel(server)
    outside.send(can.Message(is_fd=True, arbitration_id=1, data=bytes(12)))
    outside.send(can.Message(is_error_frame=True))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as raw:
        for data in (b"", b"\xff" * 1000, b"{}", bytes(4000)):
            raw.sendto(data, (GROUP, port))
    outside.send(message("100#"))
    until(lambda: channel(server)["in"] == before["in"] + 1, "the frame behind")
    assert channel(server)["refused"] == before["refused"] + 6
    assert server.ask("health")["state"] == "ok"


def test_more_than_the_bus_carries_waits_outside_and_the_bench_lives_on(
    server: Server, outside: can.BusABC
) -> None:
    before = server.ask("buses")[0]["nodes"][NODE]["sent"]
    for number in range(1500):
        outside.send(can.Message(arbitration_id=0x300, data=number.to_bytes(8, "big"), is_extended_id=False))
        if number % 100 == 99:
            time.sleep(0.005)
    until(lambda: server.ask("buses")[0]["nodes"][NODE]["waiting"] == 0, "an empty node")
    row = channel(server)
    sent = server.ask("buses")[0]["nodes"][NODE]["sent"] - before
    assert sent > 1000
    assert row["in"] >= sent


def test_a_channel_can_have_faults(place: Place, server: Server, outside: can.BusABC) -> None:
    number = server.ask("inject", fault="wire_cut", target=NODE, parameters={})
    while outside.recv(0):
        pass
    outside.send(message("000#8105"))
    time.sleep(0.2)
    server.ask("clear", **number)
    assert expect(outside, 0x705).data == b"\0", "the frame has waited for the wire"


def test_completion_knows_buses_and_channels(place: Place, server: Server) -> None:
    where = ("--runtime-dir", str(place.runtime))
    targets = place.hil("_names", "targets", "fault", "inject", "wire_cut", *where)
    assert f"{NODE}\tchannel of can0" in targets
    assert "m1.canopen\tCANopen node of can0" in targets
    assert "can0\tCAN bus" in place.hil("_names", "lines", "capture", *where)


def test_a_channel_goes_on_through_a_reload() -> None:
    port = free_port()
    wanted = bench(5, port)
    devices = wanted.pop("devices")
    with Place() as place, can.Bus(interface="udp_multicast", channel=GROUP, port=port) as outside:
        server = place.serve(config(devices=devices, **wanted))
        assert reload(place, server, devices | {"x1": {}}, **wanted) == {"added": ["x1"], "kept": ["m1"]}
        outside.send(message("000#8105"))
        assert expect(outside, 0x705).data == b"\0"
        why = refused(place, server, devices, can=wanted["can"])
        assert "bridges" in why
        server.stop()


def test_another_bench_is_on_the_same_bus(
    place: Place, server: Server, outside: can.BusABC, port: int
) -> None:
    other = place.serve(config(bench="u", **bench(6, port))).started()
    with beside(server) as here:
        outside.send(message("000#8100"))  # NMT: reset all nodes
        assert expect(here, 0x706).data == b"\0"
    other.stop()


def test_the_canopen_library_reads_objects_through_it(server: Server, outside: can.BusABC) -> None:
    import canopen

    network = canopen.Network(bus=outside)
    network.connect()
    try:
        node = network.add_node(5, canopen.ObjectDictionary())
        assert int.from_bytes(node.sdo.upload(0x1018, 1), "little") >= 0
    finally:
        network.disconnect()


@TSHARK
def test_a_capture_goes_live_into_tshark_which_knows_canopen(
    place: Place, server: Server, outside: can.BusABC
) -> None:
    capture = [HIL, "capture", "can0", "-w", "-", "--runtime-dir", str(place.runtime)]
    show = ["tshark", "-l", "-i", "-", "-c", "20", "-d", "can.subdissector,canopen", "-T", "fields"]
    show += ["-e", "_ws.col.Protocol", "-e", "_ws.col.Info", "-e", "_ws.malformed"]

    def talked(reader: subprocess.Popen[str]) -> bool:
        outside.send(message("605#4018100100000000"))
        return reader.poll() is not None

    with (
        subprocess.Popen(capture, stdout=subprocess.PIPE) as writer,
        subprocess.Popen(show, stdin=writer.stdout, stdout=subprocess.PIPE, text=True) as reader,
    ):
        until(lambda: talked(reader), "frames in tshark", 60)
        writer.terminate()
        assert reader.stdout
        rows = [line.split("\t") for line in reader.stdout.read().splitlines()]
    assert len(rows) == 20
    assert {row[0] for row in rows} == {"CANopen"}
    assert {row[2] for row in rows} == {""}
    assert "Default-SDO (rx): Initiate upload request" in {row[1].partition(" [")[0] for row in rows}


def test_a_capture_as_text_says_who_sent_what(place: Place, server: Server, outside: can.BusABC) -> None:
    path = place.folder / "can0.pcapng"
    with Capturing(place, "can0", str(path)):
        outside.send(message("605#4018100100000000"))
        expect(outside, 0x585)
        until(lambda: "Vendor-ID is" in place.hil("decode", str(path)), "the answer")
    text = place.hil("decode", str(path), "--eds", f"5={place.write(EDS, 'gripper.eds')}")
    assert f"SDO to 5: read 1018h:1 Identity, Vendor ({NODE})" in text
    assert "(m1.canopen)" in text


EDS = "[1018sub1]\nParameterName=Vendor\nDataType=0x0007\n"


def test_strange_files_are_refused_with_their_places(place: Place) -> None:
    for name, content, why in (
        ("a.log", "(1.0) can0 123#0\n", "a.log: there is nothing in it that can be read; 1 left out"),
        ("b.pcapng", "x" * 20, "b.pcapng: this is no capture (pcapng, pcap) and no log"),
        ("e.pcapng", "{}", "e.pcapng: this is no capture (pcapng, pcap) and no log"),
        ("c.blf", "x" * 500, "c.blf: python-can cannot read it"),
    ):
        assert why in place.hil("decode", str(place.write(content, name)), code=2)
    good = str(place.write("(1.0) can0 123#00\n", "d.log"))
    assert "write a node id of 1 to 127" in place.hil("decode", good, "--eds", "128=x", code=2)
    bad = place.write("[2000]\nnonsense\n", "x.eds")
    assert "x.eds: there is no object in it" in place.hil("decode", good, "--eds", f"5={bad}", code=2)


def test_what_a_log_cannot_have_is_refused(place: Place, server: Server) -> None:
    where = ("--runtime-dir", str(place.runtime))
    said = place.hil("capture", "can0", "-w", "x.log", "--rotate", "1", *where, code=2)
    assert "--rotate needs --write with a file of pcapng" in said
    name = str(place.folder / "m.log")
    assert "m1 is no CAN bus; name the file .pcapng" in place.hil("capture", "m1", "-w", name, *where, code=1)
    assert not (place.folder / "m.log").exists(), "it is refused before anything is written"
    assert "can0" in place.hil("capture", "can9", "-w", "x.log", *where, code=2)


CHANNELS = """
bench: t
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
can: {can0: {nodes: {m1: 5}}}
bridges:
  can:
    channels:
"""


@pytest.mark.parametrize(
    ("channels", "where", "why"),
    [
        ("can1: {interface: virtual}", "9:7", "there is no CAN bus 'can1'"),
        ("can0: {interface: udp_multicast, channel: 10.0.0.1}", "9:49", "10.0.0.1 is no multicast address"),
        ("can0: {interface: usb}", "9:25", "udp_multicast"),
        ("can0: {interface: virtual, port: 5}", "9:40", "port is for udp_multicast alone"),
        ("can0: {interface: socketcan}", "9:25", "socketcan needs a channel"),
        ("can0: {interface: virtual}\n      can0.b: {interface: virtual}", "10:7", "go round forever"),
        (
            "can0: {interface: virtual, channel: a}\n      can0.virtual: {interface: virtual, channel: b}",
            "10:7",
            "it is the node can0.virtual, as can0 is",
        ),
        ("can0: []", "9:13", "keys are wanted here"),
        ("can0.A: {interface: virtual}", "9:7", "'A' is no name"),
    ],
)
def test_what_cannot_be_a_channel_is_refused_with_its_place(
    place: Place, channels: str, where: str, why: str
) -> None:
    path = place.write(CHANNELS + f"      {channels}\n", "wrong.yaml")
    said = place.cli("check", str(path), code=2)
    assert why in said, said
    assert f"{path}:{where}" in said, said


def has_can() -> bool:
    try:
        socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return False
    return True


@pytest.mark.skipif(has_can(), reason="this kernel has CAN sockets")
def test_a_kernel_without_can_is_told(place: Place) -> None:
    path = place.write(CHANNELS + "      can0: {interface: socketcan, channel: vcan0}\n", "no_can.yaml")
    said = place.cli("check", str(path), code=2)
    assert "this kernel has no CAN sockets" in said
    assert "modprobe -a can_raw vcan" in said
    assert "this kernel has no CAN sockets" in place.launch(path.read_text()).refused()


def test_a_bench_without_channels_does_not_import_python_can(place: Place) -> None:
    source = (
        "import sys; from hil.config import from_dict; import bridges.can.bridge; print('can' in sys.modules)"
    )
    shown = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    assert shown.stdout == "False\n"


def test_the_log_is_the_same_again(place: Place, server: Server) -> None:
    """Last of this file: the daemon ends."""
    server.stop()
    replayed = place.hil("replay", str(place.folder / "inputs.log"), timeout_s=60)
    assert "identical" in replayed, replayed
