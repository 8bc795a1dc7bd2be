"""Dissection of the door's traffic by tshark, which finds nothing malformed."""

import json
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Any

import pytest
from served_door import Door, packet, with_door
from served_line import Line, good, on_line

DOOR_PORT, CLIENT_PORT = 502, 40000
PDUS = [
    bytes.fromhex(pdu)
    for pdu in (
        "01 0000 0001",
        "02 0000 0001",
        "02 00c8 0007",
        "03 0000 0001",
        "04 0000 0014",
        "04 03e8 0002",
        "05 0000 ff00",
        "06 0000 0000",
        "0f 0000 0001 01 00",
        "10 000b 0001 02 0001",
        "16 0000 ffff 0000",
        "17 0000 0001 0000 0001 02 0000",
        "2b 0e 01 00",
        "2b 0e 02 00",
        "2b 0e 04 01",
        "41 00",  # refusals
        "04 ffff 0002",
        "05 0000 1234",
        "06 000b 0063",
    )
]
OF_LINES = [*PDUS, bytes.fromhex("08 0000 a537"), bytes.fromhex("08 000b 0000"), bytes.fromhex("11")]
pytestmark = pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")


class Capture:
    """TCP connection in a file that tshark reads, of what was sent both ways."""

    def __init__(self) -> None:
        self._sent = {DOOR_PORT: 0, CLIENT_PORT: 0}
        # Magic number with microseconds, version 2.4, zone, accuracy, length, LINKTYPE_RAW: bare IP packets.
        self._file = bytearray(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 101))
        self._count = 0

    def add(self, payload: bytes, *, is_answer: bool) -> None:
        source, target = (DOOR_PORT, CLIENT_PORT) if is_answer else (CLIENT_PORT, DOOR_PORT)
        seen = 1 + self._sent[source], 1 + self._sent[target]
        tcp = struct.pack(">HHIIBBHHH", source, target, *seen, 5 << 4, 0x18, 8192, 0, 0) + payload
        local = bytes((127, 0, 0, 1))
        data = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(tcp), 0, 0, 64, 6, 0, local, local) + tcp
        self._file += struct.pack("<IIII", 0, self._count, len(data), len(data)) + data
        self._sent[source] += len(payload)
        self._count += 1

    def dissected(self, folder: Path, protocol: str, *options: str) -> list[Any]:
        """Layers of all packets, as tshark sees them."""
        path = folder / "door.pcap"
        path.write_bytes(self._file)
        command = ["tshark", "-r", path, "-d", f"tcp.port=={DOOR_PORT},{protocol}", *options, "-T", "json"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
        return [each["_source"]["layers"] for each in json.loads(done.stdout)]


def check(packets: list[Any], pdus: list[bytes]) -> None:
    """Check that every packet is Modbus of its function, and that nothing is said against it."""
    assert len(packets) == 2 * len(pdus)
    for at, layers in enumerate(packets):
        text, pdu = json.dumps(layers), pdus[at // 2]
        if "mbtcp" not in text and at % 2 == 0 and len(pdu) == 1:
            continue  # tshark takes no frame of four bytes for one of Modbus RTU
        assert "_ws.malformed" not in text, (pdu.hex(), text)
        assert "Expert Info (Error" not in text, (pdu.hex(), text)
        assert f'"modbus.func_code": "{pdu[0]}"' in text, (pdu.hex(), text)


def test_nothing_over_tcp_is_malformed(tmp_path: Path) -> None:
    capture = Capture()

    async def use(door: Door) -> None:
        client = await door.client()
        for at, pdu in enumerate(PDUS, 1):
            request = packet(pdu, at)
            await client.send(request)
            transaction, unit, answer = await client.answer()
            capture.add(request, is_answer=False)
            capture.add(packet(answer, transaction, unit), is_answer=True)

    with_door(use)
    check(capture.dissected(tmp_path, "mbtcp"), PDUS)


def test_nothing_on_a_line_is_malformed(tmp_path: Path) -> None:
    capture = Capture()

    async def use(line: Line) -> None:
        for pdu in OF_LINES:
            capture.add(good(pdu), is_answer=False)
            capture.add(await line.ask(good(pdu)), is_answer=True)

    on_line(use)
    packets = capture.dissected(tmp_path, "mbrtu", "-o", "mbrtu.crc_verification:TRUE")
    check(packets, OF_LINES)
    seen = json.dumps(packets)
    assert (
        seen.count('"mbrtu.crc16.status": "1"') == seen.count('"mbrtu.unit_id"') == len(packets) - 1
    )  # good


def test_the_check_finds_what_is_malformed(tmp_path: Path) -> None:
    capture = Capture()
    capture.add(packet(bytes.fromhex("2b 0e 01 00")), is_answer=False)
    capture.add(packet(bytes.fromhex("2b 0e 01 01 00 00 01 00 09 68")), is_answer=True)
    with pytest.raises(AssertionError, match="malformed"):
        check(capture.dissected(tmp_path, "mbtcp"), [b"\x2b"])
