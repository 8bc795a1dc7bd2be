"""The examples of the application protocol, as a server and as a client see them."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from bridges.modbus.protocol.client_side import encode, parse_answer
from bridges.modbus.protocol.diagnostics import Diagnostics
from bridges.modbus.protocol.identification import Identification, identify
from bridges.modbus.protocol.pdu import (
    Code,
    Mask,
    Refused,
    Request,
    Span,
    Table,
    Write,
    answer,
    exception,
    parse,
)

BOOK = yaml.safe_load((Path(__file__).parent / "section_6.yaml").read_text())
LEVEL_AT = 3
ROOM = 64
"""Bytes of an answer that split the second identification as the book does."""


def asked(case: dict[str, Any]) -> Request:
    """Request as the case says it in words."""
    table, *rest = case.get("read", [None])
    write_table, *written = case.get("write", [None])
    return Request(
        bytes.fromhex(case["request"])[0],
        Span(Table(table), *rest) if table else None,
        Write(Table(write_table), written[0], tuple(written[1])) if write_table else None,
        Mask(*case["mask"]) if "mask" in case else None,
        case.get("sub_function"),
        bytes.fromhex(case.get("data", "")),
    )


def read_values(case: dict[str, Any]) -> tuple[int, ...]:
    bits = case.get("bits", "").replace(" ", "")
    return tuple(case.get("registers", map(int, bits)))


@pytest.mark.parametrize("case", BOOK["known"], ids=lambda case: case["section"])
def test_an_example(case: dict[str, Any]) -> None:
    pdu, reply = bytes.fromhex(case["request"]), bytes.fromhex(case["answer"])
    request, values = asked(case), read_values(case)
    assert parse(pdu, is_serial_line=True) == request
    assert encode(request) == pdu
    made = Diagnostics().answer(request) if "data" in case else answer(request, values)
    assert made == reply
    assert parse_answer(request, reply)[:2] == (values, request.data)
    if request.mask:
        assert request.mask.applied(case["before"]) == case["after"]


@pytest.mark.parametrize("case", BOOK["refused"], ids=lambda case: case["section"])
def test_an_example_of_a_function_that_is_not_known(case: dict[str, Any]) -> None:
    with pytest.raises(Refused) as refused:
        parse(bytes.fromhex(case["request"]), is_serial_line=True)
    assert refused.value.code == Code.ILLEGAL_FUNCTION


@pytest.mark.parametrize("case", BOOK["identification"], ids=["whole", "in two"])
def test_an_example_of_identification(case: dict[str, Any]) -> None:
    device = Identification(*case["objects"])
    for piece in case["pieces"]:
        texts = {number: case["objects"][number].encode() for number in piece["objects"]}
        objects = b"".join(bytes((number, len(text))) + text for number, text in texts.items())
        reply = bytes.fromhex(piece["head"]) + objects
        request = parse(bytes.fromhex(piece["request"]))
        assert encode(request) == bytes.fromhex(piece["request"])
        made = bytearray(identify(request, device, ROOM))
        assert made[LEVEL_AT] == reply[LEVEL_AT] | 0x80, "single objects may be asked for here"
        made[LEVEL_AT] = reply[LEVEL_AT]
        assert bytes(made) == reply
        read = parse_answer(request, reply).identification
        assert read
        next_object_id = case["pieces"][-1]["objects"][0] if reply[4] else None
        assert read == (request.read_device_id_code, reply[LEVEL_AT], next_object_id, texts)


def test_the_example_of_an_exception() -> None:
    case = BOOK["exception"]
    request, reply = parse(bytes.fromhex(case["request"])), bytes.fromhex(case["answer"])
    assert exception(request.function, Code(case["code"])) == reply
    with pytest.raises(Refused, match="function 1: illegal data address") as refused:
        parse_answer(request, reply)
    assert refused.value.code == case["code"]
