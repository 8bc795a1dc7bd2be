"""The board without a motor on an RS485 line, in simulated time."""

import struct
from typing import Any

from bridges.modbus.protocol.client_side import encode, parse_answer, read, write
from bridges.modbus.protocol.frame import encode as frame
from bridges.modbus.protocol.pdu import Refused, Request, Table
from hil.testing import Bench

INPUT, HOLDING = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS
UNIT = 7
MAP = {
    "modbus_map": 2,
    "protocol": {"pause_ms": 10, "functions": [3, 4, 16]},
    "cells": {
        "level": {"input": 0, "type": "i16", "scale": 0.1, "value": -2.5},
        "serial": {"input": 1, "type": "u64", "value": 2**63 - 1},
        "name": {"input": 5, "type": "text", "registers": 3, "value": "hil-1"},
        "count": {"holding": 0, "type": "i48", "word_order": "low_first", "stored": "at_once"},
        "decimals": {"holding": 3, "value": 1, "maximum": 3},
        "power": {"input": 8, "decimals": "decimals", "value": 12.5},
    },
}


class Line:
    """Line with one meter and a master."""

    def __init__(self, **device: Any) -> None:
        segment = {
            "baud": 115200,
            "modbus": {"units": {"meter": UNIT}, "response_ms": 0},
            "taps": {"plc": {"port": "memory"}},
        }
        meter = {"profile": "modbus_meter", **device}
        self.bench = Bench({"bench": "t", "devices": {"meter": meter}, "segments": {"bus": segment}})
        self.bench.run(ms=250)

    def ask(self, request: Request, wait_ms: float = 25) -> Any:
        """Send a request; answers what was read, the number of an exception, or None without an answer."""
        tap = self.bench.tap("bus.plc")
        tap.read()
        pdu = encode(request)
        tap.write(frame(UNIT, pdu[0], pdu[1:]))
        self.bench.run(ms=wait_ms)
        answer = tap.read()
        if not answer:
            return None
        try:
            return parse_answer(request, answer[1:-2]).values
        except Refused as error:
            return int(error.code)


def test_the_map_that_is_built_in_has_floats_that_are_set_from_outside() -> None:
    line = Line()
    assert line.ask(read(INPUT, 0, 2)) == struct.unpack(">2H", struct.pack(">f", 230.0))
    line.bench.device("meter").do("cells", values="voltage_V=231.5")
    assert line.ask(read(INPUT, 0, 2)) == struct.unpack(">2H", struct.pack(">f", 231.5))
    line.bench.close()


def test_wide_numbers_texts_and_scales_of_other_registers() -> None:
    line = Line(map=MAP)
    assert line.ask(read(INPUT, 0, 1)) == (0x10000 - 25,)
    assert line.ask(read(INPUT, 1, 4)) == (0x7FFF, 0xFFFF, 0xFFFF, 0xFFFF)
    assert line.ask(read(INPUT, 5, 3)) == (0x6869, 0x6C2D, 0x3100)
    assert line.ask(read(INPUT, 8, 1)) == (125,)
    assert (
        line.ask(
            write(
                HOLDING,
                3,
                (2,),
            )
        )
        == ()
    )
    assert line.ask(read(INPUT, 8, 1)) == (1250,)
    assert line.ask(write(HOLDING, 3, (4,))) == 3
    assert line.ask(write(HOLDING, 0, (0x3333, 0x2222, 0x8111))) == ()
    assert line.ask(read(HOLDING, 0, 3)) == (0x3333, 0x2222, 0x8111)
    line.bench.device("meter").reset()
    line.bench.run(ms=300)
    assert line.ask(read(HOLDING, 0, 4)) == (0x3333, 0x2222, 0x8111, 1)
    line.bench.close()


def test_a_request_within_the_pause_is_not_heard_and_a_missing_function_is_refused() -> None:
    line = Line(map=MAP)
    assert line.ask(read(INPUT, 0, 1), wait_ms=5) == (0x10000 - 25,)
    assert line.ask(read(INPUT, 0, 1), wait_ms=5) is None
    line.bench.run(ms=20)
    assert line.ask(read(INPUT, 0, 1)) == (0x10000 - 25,)
    assert line.ask(read(Table.COILS, 0, 1)) == 1
    line.bench.close()


def test_a_ramp_begins_when_it_is_asked_for_and_not_at_the_step_before() -> None:
    bench = Line().bench
    meter = bench.device("meter")
    for _ in range(20):  # steps come each 20 ms
        meter.do("cells", values="power_W=0")
        meter.do("cells", values="power_W=100", over_s=0.1)
        bench.run(ms=2)
        assert bench.runtime.devices["meter"].told["cell.power_W"] <= 2
        bench.run(ms=19)
