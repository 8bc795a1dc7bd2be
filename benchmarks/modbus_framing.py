"""Time for a packet of Modbus from its bytes to a checked PDU, on a serial line and over TCP, and for the
answer to a request.

Beside it, in turns, pymodbus (extra dev): its framers with the same bytes, and its classes for the same
request and answer; at most as much is wanted. On a serial line ours tells frames by their times, theirs gets
whole ones.
"""

import statistics
import time
from collections.abc import Callable

from _report import is_quick, report

from bridges.modbus.protocol import mbap
from bridges.modbus.protocol.client_side import encode as encode_request
from bridges.modbus.protocol.client_side import read
from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.pdu import Table, answer, parse
from bridges.modbus.protocol.splitter import RtuSplitter
from hil.vocab.time import SimTimeNs
from hil.wire.serial_line import character_ns, silence_ns

BAUD = 115200
PACKETS = 5_000 if is_quick() else 50_000
RUNS = 3 if is_quick() else 11
NODE = 17
VALUES = list(range(10))

Work = Callable[[], int]
"""Work that answers how many packets were good."""


def rtu(frame: bytes) -> Work:
    """Frames one behind the other, each a burst, with its CRC checked and its PDU taken out."""
    period_ns = character_ns(len(frame), BAUD) + 2 * silence_ns(BAUD)

    def run() -> int:
        splitter, good = RtuSplitter(), 0
        for at_ns in range(0, (PACKETS + 1) * period_ns, period_ns):
            for item in splitter.burst(frame, SimTimeNs(at_ns), BAUD).items:
                good += not item.fault and len(item.raw[1:-2]) > 0  # type: ignore[attr-defined]
        return good

    return run


def tcp(packet: bytes) -> Work:
    def run() -> int:
        splitter = mbap.MbapSplitter()
        return sum(len(splitter.feed(packet)) for _ in range(PACKETS))

    return run


def their_framer(name: str, packet: bytes, *, is_request: bool) -> Work | None:
    try:
        from pymodbus import framer
        from pymodbus.pdu import DecodePDU
    except ImportError:
        return None
    decode = getattr(framer, name)(DecodePDU(is_server=is_request)).decode

    def run() -> int:
        good = 0
        for _ in range(PACKETS):
            _, node, _, pdu = decode(packet)
            good += node == NODE and len(pdu) > 0
        return good

    return run


def answers(pdu: bytes) -> Work:
    def run() -> int:
        return sum(len(answer(parse(pdu), VALUES)) > 0 for _ in range(PACKETS))

    return run


def their_answers(pdu: bytes) -> Work | None:
    try:
        from pymodbus.pdu import DecodePDU
        from pymodbus.pdu.register_message import ReadHoldingRegistersResponse
    except ImportError:
        return None
    decode = DecodePDU(is_server=True).decode

    def run() -> int:
        good = 0
        for _ in range(PACKETS):
            good += decode(pdu) is not None
            bytes((3,)) + ReadHoldingRegistersResponse(registers=VALUES).encode()
        return good

    return run


def medians_us(works: tuple[Work | None, ...]) -> list[float]:
    """Median time of each for one packet, in turns; 0 for what is not there."""
    times_us: list[list[float]] = [[] for _ in works]
    for _ in range(RUNS):
        for work, found in zip(works, times_us, strict=True):
            if work:
                began = time.perf_counter()
                assert work() == PACKETS
                found.append((time.perf_counter() - began) / PACKETS * 1e6)
    return [statistics.median(found) if found else 0.0 for found in times_us]


def main() -> None:
    ten, most = (read(Table.HOLDING_REGISTERS, 0, count) for count in (10, 125))
    request, ten_read, most_read = encode_request(ten), answer(ten, VALUES), answer(most, range(125))
    rows: dict[str, tuple[Work | None, ...]] = {}
    for name, pdu in {"request": request, "answer_10": ten_read, "answer_125": most_read}.items():
        frame, packet = encode(NODE, pdu[0], pdu[1:]), mbap.encode(1, NODE, pdu)
        is_request = pdu is request
        rows[f"rtu_{name}"] = rtu(frame), their_framer("FramerRTU", frame, is_request=is_request)
        rows[f"tcp_{name}"] = tcp(packet), their_framer("FramerSocket", packet, is_request=is_request)
    rows["pdu"] = answers(request), their_answers(request)
    for name, works in rows.items():
        mine, reference = medians_us(works)
        limit = 1 if reference else None
        report(f"modbus_{name}", mine, "us", reference, limit, {"reference": "pymodbus, or 0 without it"})
        print(f"  {1e6 / mine:,.0f} a second")


main()
