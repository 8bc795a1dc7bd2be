"""Frames of CANopen in words: each service, and dialogues as the standard has them."""

import os
import random
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.canopen.words.canopen_words import CanOpenWords
from bridges.can.canopen.words.eds_names import read_eds
from bridges.can.canopen.words.object_words import ObjectWords
from bridges.can.canopen.words.sdo_words import SdoWords
from bridges.can.frames.can_frame import CanFrame
from hil.wire.outside_text import LeftOut

ONE_FRAME = [
    ("000#0105", "NMT to node 5: start"),
    ("000#8200", "NMT to all nodes: reset communication"),
    ("000#0700", "NMT to all nodes: unknown command 7"),
    ("000#01", "NMT with 1 bytes, it has 2"),
    ("080#", "SYNC"),
    ("080#07", "SYNC 7"),
    ("085#1186050000000000", "EMCY of 5: following error (8611h), error register 05h (generic, voltage)"),
    ("085#0000000000000000", "EMCY of 5: no error any more (0000h), error register 00h"),
    ("085#30FF800100000000", "EMCY of 5: of the device itself (FF30h), error register 80h (manufacturer),"
                             " manufacturer 01 00 00 00 00"),
    ("085#99", "EMCY of 5: 1 bytes, it has 8"),
    ("100#E8030000 0100", "TIME 1.000 s of day 1 since 1984"),
    ("705#00", "boot-up of 5"),
    ("705#7F", "heartbeat of 5: pre-operational"),
    ("705#85", "heartbeat of 5: operational, toggled"),
    ("705#R1", "guarding of 5: what is your state"),
    ("185#0011", "TPDO1 of 5"),
    ("505#0011", "RPDO4 of 5"),
    ("285#R", "TPDO2 of 5 is asked for"),
    ("605#4041600000000000", "SDO to 5: read 6041h Statusword"),
    ("605#401810 0100000000", "SDO to 5: read 1018h:1 Identity, Vendor-ID"),
    ("585#4B41600037020000", "SDO from 5: 6041h Statusword is 0237h"),
    ("585#4364600018FCFFFF", "SDO from 5: 6064h Position actual value is -1000"),
    ("585#8041600002000106", "SDO from 5: abort 6041h Statusword: it can only be read (06010002h)"),
    ("605#2B171000E8030000", "SDO to 5: write 1017h Producer heartbeat time (ms) = 1000"),
    ("605#41", "SDO to 5: 1 bytes, an SDO has 8"),
    ("7E5#0401000000000000", "LSS: all: configuration"),
    ("7E5#1107000000000000", "LSS: set the node id to 7"),
    ("7E4#1100000000000000", "LSS of a node: node id: done"),
    ("7E5#1300020000000000", "LSS: set the bit rate to 500 kbit/s"),
    ("7E5#1300090000000000", "LSS: set the bit rate to what is found"),
    ("7E5#5A00000000000000", "LSS: what is your vendor-id"),
    ("7E4#5A78563412000000", "LSS of a node: vendor-id 12345678h"),
    ("7E5#4978563412000000", "LSS: who has highest revision number 12345678h"),
    ("7E5#5100000000800000", "LSS: fastscan: who has no node id yet"),
    ("7E5#51000000001F0000", "LSS: fastscan: whose vendor-id is 00000000h from bit 31 on"),
    ("7E5#5178563412000001", "LSS: fastscan: whose vendor-id is 12345678h, then product code"),
    ("7E4#4F00000000000000", "LSS of a node: here is such a node"),
    ("780#00", ""),
    ("00000005#00", ""),
]  # fmt: skip


def frame_of(text: str) -> CanFrame:
    identifier, _, rest = text.replace(" ", "").partition("#")
    is_extended = len(identifier) == 8
    if rest.startswith("R"):
        return CanFrame(int(identifier, 16), b"", is_extended, True, int(rest[1:] or 0))
    return CanFrame(int(identifier, 16), bytes.fromhex(rest), is_extended)


@pytest.mark.parametrize(("frame", "words"), ONE_FRAME, ids=[frame for frame, _ in ONE_FRAME])
def test_a_frame_in_words(frame: str, words: str) -> None:
    assert CanOpenWords().say(frame_of(frame)) == words


class Dialogue:
    """Transfers of object 2000h by the standard's frames; ``moved``: those that the words have understood."""

    def __init__(self) -> None:
        self.moved: list[tuple[int, int, bytes]] = []
        self.words = SdoWords(ObjectWords(), lambda *each: self.moved.append(each))
        self.said: list[str] = []

    def ask(self, *data: int) -> None:
        self.said.append(self.words.request(bytes(data).ljust(8, b"\0")))

    def answer(self, *data: int) -> None:
        self.said.append(self.words.response(bytes(data).ljust(8, b"\0")))


def segments(data: bytes) -> Iterator[tuple[int, bytes, bool]]:
    """Toggle bit, piece, and whether it is the last."""
    pieces = [data[at : at + 7] for at in range(0, len(data), 7)]
    for number, piece in enumerate(pieces):
        yield number & 1, piece, number == len(pieces) - 1


@given(st.binary(min_size=1, max_size=100))
def test_segments_are_put_together(data: bytes) -> None:
    to, back = Dialogue(), Dialogue()
    to.ask(0x21, 0x00, 0x20, 3, len(data))
    to.answer(0x60, 0x00, 0x20, 3)
    back.ask(0x40, 0x00, 0x20, 3)
    back.answer(0x41, 0x00, 0x20, 3, len(data))
    for toggle, piece, is_last in segments(data):
        rest = toggle << 4 | (7 - len(piece)) << 1 | is_last
        to.ask(rest, *piece)
        to.answer(0x20 | toggle << 4)
        back.ask(0x60 | toggle << 4)
        back.answer(rest, *piece)
    assert to.moved == back.moved == [(0x2000, 3, data)]
    assert to.said[0] == f"write 2000h:3, {len(data)} bytes in segments"
    assert to.said[-1] == "2000h:3 written"


@given(st.binary(min_size=1, max_size=300), st.integers(1, 20), st.data())
def test_blocks_are_put_together(data: bytes, size: int, draw: st.DataObject) -> None:
    """Some of a block's segments may be lost, and are sent again."""
    to, back = Dialogue(), Dialogue()
    to.ask(0xC2, 0x00, 0x20, 3, len(data))
    to.answer(0xA0, 0x00, 0x20, 3, size)
    back.ask(0xA0, 0x00, 0x20, 3, size)
    back.answer(0xC2, 0x00, 0x20, 3, len(data))
    back.ask(0xA3)
    rest = [data[at : at + 7] for at in range(0, len(data), 7)]
    while rest:
        sent = rest[:size]
        for number, piece in enumerate(sent, 1):
            command = number | (0x80 if len(sent) == len(rest) and number == len(sent) else 0)
            to.ask(command, *piece)
            back.answer(command, *piece)
        taken = draw.draw(st.integers(0, len(sent))) if draw.draw(st.booleans()) else len(sent)
        to.answer(0xA2, taken, size)
        back.ask(0xA2, taken, size)
        del rest[:taken]
    unused = -len(data) % 7
    to.ask(0xC1 | unused << 2)
    to.answer(0xA1)
    back.answer(0xC1 | unused << 2)
    back.ask(0xA1)
    assert to.moved == back.moved == [(0x2000, 3, data)]
    assert to.said[-1] == "2000h:3 written"


def test_an_abort_ends_a_transfer() -> None:
    dialogue = Dialogue()
    dialogue.ask(0xC2, 0x00, 0x20, 3, 20)
    dialogue.answer(0xA0, 0x00, 0x20, 3, 5)
    dialogue.ask(1, *b"1234567")
    dialogue.answer(0x80, 0x00, 0x20, 3, 4, 0, 4, 5)
    dialogue.ask(2, *b"1234567")
    assert dialogue.said[3:] == [
        "abort 2000h:3: the CRC is wrong (05040004h)",
        "a segment of nothing",
    ]
    assert dialogue.moved == []


def test_values_of_pdos_once_their_mapping_was_seen() -> None:
    words = CanOpenWords()
    said = [
        words.say(frame_of(text))
        for text in (
            *("605#23001A0110004160", "585#60001A0100000000", "605#23001A0220006460", "585#60001A0200000000"),
            *("605#2F001A0002000000", "585#60001A0000000000", "185#370200000100", "185#3702"),
            *("605#2300180185020000", "585#6000180100000000", "285#370200000100", "185#370200000100"),
        )
    ]
    assert said[0] == "SDO to 5: write 1A00h:1 TPDO1 mapping, mapped 1 = 60410010h"
    assert said[6] == "TPDO1 of 5: Statusword 0237h, Position actual value 65536"
    assert said[7] == "TPDO1 of 5: Statusword 0237h, 2 bytes of 6"
    assert said[10] == "TPDO1 of 5: Statusword 0237h, Position actual value 65536"
    assert said[11] == "", "the identifier is nobody's now"


EDS = """
[FileInfo]
FileName=drive.eds
; a comment
[2000]
ParameterName=Grip force
ObjectType=0x7
DataType=0x0003
DefaultValue=-5
[1a00]
ParameterName=TPDO1 mapping
ObjectType=0x9
SubNumber=2
[1A00sub0]
ParameterName=Number
DataType=0x0005
DefaultValue=1
[1A00sub1]
ParameterName=First
DataType=0x0007
DefaultValue=0x20000010
[1800sub1]
ParameterName=COB-ID
DataType=0x0007
DefaultValue=$NODEID+0x380
"""


def test_names_and_first_values_of_an_eds() -> None:
    objects = read_eds(EDS, 5, LeftOut())
    words = CanOpenWords({5: objects.names}, {5: objects.values})
    assert words.say(frame_of("605#4000200000000000")) == "SDO to 5: read 2000h Grip force"
    assert words.say(frame_of("606#4000200000000000")) == "SDO to 6: read 2000h"
    assert words.say(frame_of("385#FBFF")) == "TPDO1 of 5: Grip force -5"
    assert words.say(frame_of("605#40001A0100000000")) == "SDO to 5: read 1A00h:1 TPDO1 mapping, First"
    said = words.say(frame_of("585#43001A0110004160"))
    assert said == "SDO from 5: 1A00h:1 TPDO1 mapping, First is 60410010h"


@given(st.lists(st.tuples(st.sampled_from((0x585, 0x605, 0x085, 0x7E4, 0x7E5, 0x705, 0, 0x80, 0x100, 0x185)),
                          st.binary(max_size=8)), max_size=30))  # fmt: skip
def test_any_frames_are_said(frames: list[tuple[int, bytes]]) -> None:
    words = CanOpenWords()
    for identifier, data in frames:
        assert words.say(CanFrame(identifier, data)).isprintable()


def test_fuzz_mutated_dialogues_are_said() -> None:
    """``HIL_FUZZ`` frames in a row, good ones and mutated: all are said, and good ones behind are, too."""
    chance = random.Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    corpus = [frame_of(text) for text, _ in ONE_FRAME if "R" not in text and len(text) < 30]
    corpus += [
        CanFrame(0x605, bytes((command, 0, 0x20, 3, 9, 0, 0, 0))) for command in (0xC2, 0xA0, 0x21, 0xA3)
    ]
    corpus += [
        CanFrame(0x585, bytes((command, 0, 0x20, 3, 9, 0, 0, 0))) for command in (0xC2, 0xA0, 0x41, 0x60)
    ]
    words = CanOpenWords()
    for _ in range(int(os.environ.get("HIL_FUZZ", "20000"))):
        frame = chance.choice(corpus)
        data = bytearray(frame.data)
        for _ in range(chance.choice((0, 0, 1, 2)) if data else 0):
            data[chance.randrange(len(data))] = chance.randrange(256)
        cut = chance.choice((8, 8, 8, chance.randrange(9)))
        assert words.say(frame._replace(data=bytes(data[:cut]))).isprintable()
    words.say(frame_of("605#8000200000000000"))
    assert words.say(frame_of("605#4041600000000000")) == "SDO to 5: read 6041h Statusword"
