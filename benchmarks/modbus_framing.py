"""Time for a frame of Modbus RTU from a line's bytes to a checked PDU, and for a request to be answered.

Beside both, in turns, pymodbus (extra dev): its framer with the same frames, which gets bytes and no times,
and its classes for the same request and answer. At most as much as pymodbus takes is wanted.
"""

import statistics
import time
from collections.abc import Callable

from _report import is_quick, report

from hil.vocab.time import SimTimeNs
from hil.wire.modbus.client_side import encode as encode_request
from hil.wire.modbus.client_side import read
from hil.wire.modbus.pdu import Table, answer, parse
from hil.wire.modbus_rtu.frame import encode, silence_ns
from hil.wire.modbus_rtu.splitter import RtuSplitter
from hil.wire.serial_line import character_ns

BAUD = 115200
FRAMES = 5_000 if is_quick() else 50_000
RUNS = 3 if is_quick() else 11
NODE = 17
VALUES = list(range(10))

Work = Callable[[], object]


def ours(frame: bytes) -> Work:
    """Frames one behind the other, each a burst, with its CRC checked and its data taken out."""
    period_ns = character_ns(len(frame), BAUD) + 2 * silence_ns(BAUD)

    def run() -> None:
        splitter, found = RtuSplitter(), 0
        for at_ns in range(0, (FRAMES + 1) * period_ns, period_ns):
            for item in splitter.burst(frame, SimTimeNs(at_ns), BAUD).items:
                found += not item.fault and len(item.raw[1:-2]) > 0  # type: ignore[attr-defined]
        assert found == FRAMES

    return run


def theirs(frame: bytes, is_request: bool) -> Work | None:
    try:
        from pymodbus.framer import FramerRTU
        from pymodbus.pdu import DecodePDU
    except ImportError:
        return None
    framer = FramerRTU(DecodePDU(is_server=is_request))

    def run() -> None:
        found = 0
        for _ in range(FRAMES):
            _, node, _, pdu = framer.decode(frame)
            found += node == NODE and len(pdu) > 0
        assert found == FRAMES

    return run


def our_answers(pdu: bytes) -> Work:
    def run() -> None:
        for _ in range(FRAMES):
            answer(parse(pdu), VALUES)

    return run


def their_answers(pdu: bytes) -> Work | None:
    try:
        from pymodbus.pdu import DecodePDU
        from pymodbus.pdu.register_message import ReadHoldingRegistersResponse
    except ImportError:
        return None
    decoder = DecodePDU(is_server=True)

    def run() -> None:
        for _ in range(FRAMES):
            assert decoder.decode(pdu)
            bytes((3,)) + ReadHoldingRegistersResponse(registers=VALUES).encode()

    return run


def medians_us(works: list[Work | None]) -> list[float]:
    """Median time of each for one frame, in turns; 0 for what is not there."""
    times_us: list[list[float]] = [[] for _ in works]
    for _ in range(RUNS):
        for work, found in zip(works, times_us, strict=True):
            if work:
                began = time.perf_counter()
                work()
                found.append((time.perf_counter() - began) / FRAMES * 1e6)
    return [statistics.median(found) if found else 0.0 for found in times_us]


def main() -> None:
    ten, most = (read(Table.HOLDING_REGISTERS, 0, count) for count in (10, 125))
    request = encode_request(ten)
    frames = {
        "request": (encode(NODE, request[0], request[1:]), True),
        "answer_10": (encode(NODE, 3, answer(ten, VALUES)[1:]), False),
        "answer_125": (encode(NODE, 3, answer(most, range(125))[1:]), False),
    }
    rows = {name: [ours(frame), theirs(frame, asks)] for name, (frame, asks) in frames.items()}
    rows["pdu"] = [our_answers(request), their_answers(request)]
    for name, works in rows.items():
        mine, reference = medians_us(works)
        limit = 1 if reference else None
        report(f"modbus_{name}", mine, "us", reference, limit, {"reference": "pymodbus, or 0 without it"})
        print(f"  {1e6 / mine:,.0f} a second")


main()
