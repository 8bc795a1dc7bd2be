"""Frames in words: questions, answers to them, and which is which."""

import pytest

from bridges.modbus.protocol import client_side as client
from bridges.modbus.protocol.exchange import is_answer
from bridges.modbus.protocol.frame import Frame, encode
from bridges.modbus.protocol.frame_words import said
from bridges.modbus.protocol.identification import Identification, ReadDeviceId, identify
from bridges.modbus.protocol.pdu import Request, Table, answer
from bridges.modbus.protocol.rtu_framing import MODBUS_RTU

HOLDING, COILS, INPUT = Table.HOLDING_REGISTERS, Table.COILS, Table.INPUT_REGISTERS


def frame(pdu: bytes) -> bytes:
    return encode(17, pdu[0], pdu[1:])


@pytest.mark.parametrize(
    ("request_", "values", "asked", "answered"),
    [
        (client.read(COILS, 4), (1,), "read coil 4", "coil 4: 1"),
        (client.read(INPUT, 6, 2), (1, 2), "read input registers 6 to 7", "input registers 6 to 7: 1 2"),
        (client.write_single(COILS, 8, 1), (), "write coil 8: 1", "coil 8 written"),
        (client.write_single(HOLDING, 0, 5), (), "write holding register 0: 5", "holding register 0 written"),
        (
            client.write(HOLDING, 0, (5, 6)),
            (),
            "write holding registers 0 to 1: 5 6",
            "holding registers 0 to 1 written",
        ),
        (client.write(COILS, 3, (1, 0)), (), "write coils 3 to 4: 1 0", "coils 3 to 4 written"),
        (
            client.mask_write(4, 0xF2, 0x25),
            (),
            "mask holding register 4: and 00f2h or 0025h",
            "holding register 4 masked",
        ),
        (
            client.read_write(3, 1, 9, (7,)),
            (8,),
            "write holding register 9: 7, read holding register 3",
            "holding register 3: 8",
        ),
    ],
)
def test_requests_and_their_answers(
    request_: Request, values: tuple[int, ...], asked: str, answered: str
) -> None:
    question, reply = frame(client.encode(request_)), frame(answer(request_, values))
    assert said(question, b"") == f"to 17: {asked}"
    assert is_answer(question, reply)
    assert said(reply, question) == f"from 17: {answered}"


def test_what_a_node_says_of_itself() -> None:
    identity = Identification("hil", "sac", "1")
    request = client.ask_identification(ReadDeviceId.BASIC)
    question = frame(client.encode(request))
    assert said(question, b"") == "to 17: identification, category 1 from object 0"
    reply = frame(identify(request, identity))
    assert said(reply, question) == "from 17: identification: 0 'hil', 1 'sac', 2 '1'"
    question = frame(client.encode(client.ask_report()))
    assert said(question, b"") == "to 17: report server ID"
    assert said(encode(17, 17, b"\x02s\xff"), question) == r"from 17: server ID: 's\xff'"
    question = frame(client.encode(client.diagnose(11)))
    assert said(question, b"") == "to 17: diagnosis 11: 00 00"
    assert said(encode(17, 8, b"\0\x0b\0\7"), question) == "from 17: diagnosis 11: 00 07"


def test_exceptions() -> None:
    question = frame(client.encode(client.read(COILS, 4)))
    assert said(encode(17, 0x81, b"\6"), question) == "from 17: function 1: exception 06 (server device busy)"
    assert said(encode(17, 0x81, b"\x63"), question) == "from 17: function 1: exception 99 (unknown)"
    assert said(encode(17, 0x81, b"\6"), b"").startswith("to 17: exception 06 (server device busy), which")
    assert not is_answer(question, encode(17, 0x81)), "without a code"
    assert said(encode(17, 0x81), b"") == "17, function 129 (an exception without its code)"


@pytest.mark.parametrize(
    "raw", [encode(17, 99, b"\1"), encode(17, 99), encode(17, 3, b"\0"), encode(17, 43, b"\1")]
)
def test_what_nobody_knows_is_told_in_digits(raw: bytes) -> None:
    assert said(raw, b"").startswith(f"17, function {raw[1]}")


def test_questions_and_answers_take_turns() -> None:
    """A write and its answer are alike; a question may be asked again."""
    write, ask = encode(17, 6, b"\0\1\0\3"), encode(17, 3, b"\0\1\0\2")
    splitter, at_ns, heard = MODBUS_RTU.splitter(), 0, list[str]()
    for raw in (
        write,
        write,
        write,
        write,
        ask,
        ask,
        encode(17, 3, b"\4\0\0\0\1"),
        encode(18, 3, b"\0\1\0\1"),
    ):
        splitter.burst(raw, at_ns, 9600)  # type: ignore[arg-type]
        at_ns += 10**9
        heard += [MODBUS_RTU.text(item).partition(":")[0] for item in splitter.silence(at_ns)]  # type: ignore[arg-type]
    wrong = write[:-1] + b"\0"
    assert not is_answer(wrong, write), "nobody answers what is spoiled: it is asked again"
    assert heard == ["to 17", "from 17", "to 17", "from 17", "to 17", "to 17", "from 17", "to 18"]


def test_the_question_is_no_part_of_what_a_frame_is() -> None:
    assert Frame(0, b"1234").as_answer(b"x") == Frame(0, b"1234")
