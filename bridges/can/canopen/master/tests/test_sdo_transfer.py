"""SDO transfers of a client: pure, against the bytes of CiA 301 and the library ``canopen``'s server."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.canopen.master.sdo_transfer import MOST_BYTES, SdoTransfer, TransferAborted, TransferGarbled


def test_expedited_transfers_take_one_frame_each_way() -> None:
    read = SdoTransfer(0x6041)
    assert read.first() == bytes.fromhex("4041600000000000")
    assert read.hear(bytes.fromhex("4b41600037020000")) is None
    assert (read.is_done, read.result) == (True, b"\x37\x02")
    write = SdoTransfer(0x607A, 0, (90_000).to_bytes(4, "little"))
    assert write.first() == bytes.fromhex("237a6000905f0100")
    assert write.hear(bytes.fromhex("607a600000000000")) is None
    assert write.is_done
    assert SdoTransfer(0x6060, 0, b"\x08").first() == bytes.fromhex("2f60600008000000")


class Segments:
    """Server of one object that is longer than four bytes, by the book."""

    def __init__(self, data: bytes, index: int, is_write: bool) -> None:
        self.data, self.name = data, index.to_bytes(2, "little") + b"\0"
        self.got, self.toggle, self.is_write = b"", 0, is_write

    def answer(self, request: bytes) -> bytes:
        if request[0] >> 5 == 2:
            return b"\x41" + self.name + len(self.data).to_bytes(4, "little")
        if request[0] >> 5 == 1 and not self.got and request[1:4] == self.name and not self.toggle:
            self.toggle = -1
            return b"\x60" + self.name + bytes(4)
        if self.is_write:
            self.got += request[1 : 8 - (request[0] >> 1 & 7)]
            return bytes([0x20 | request[0] & 0x10]) + bytes(7)
        part, self.data = self.data[:7], self.data[7:]
        return bytes([request[0] & 0x10 | (7 - len(part)) << 1 | (not self.data)]) + part.ljust(7, b"\0")


def carried_out(transfer: SdoTransfer, server: Segments) -> bytes:
    request: bytes | None = transfer.first()
    while request is not None:
        assert len(request) == 8
        request = transfer.hear(server.answer(request))
    return transfer.result


@given(st.binary(min_size=5, max_size=300))
def test_segments_carry_all_bytes_both_ways(data: bytes) -> None:
    assert carried_out(SdoTransfer(0x1008), Segments(data, 0x1008, False)) == data
    far = Segments(b"", 0x1008, True)
    carried_out(SdoTransfer(0x1008, 0, data), far)
    assert far.got == data


def test_an_empty_value_is_written_in_a_segment() -> None:
    far = Segments(b"", 0x1008, True)
    carried_out(SdoTransfer(0x1008, 0, b""), far)
    assert far.got == b""


@pytest.mark.parametrize(
    ("answers", "why"),
    [
        (["4b"], "was answered with 1 bytes, not 8"),
        (["6041600000000000"], "a read of 6041h:00 was answered with command 60h"),
        (["4b42600037020000"], "a read of 6041h:00 was answered for 6042h:00"),
        (["4141600014000000", "1000000000000000"], "an answer came twice, or one is missing"),
        (["4141600002000000", "0000000000000000"], "more bytes than were announced"),
        (["4141600009000000", "0100000000000000"], "fewer bytes than were announced"),
        (["4141600009000000", "6000000000000000"], "was answered with command 60h"),
    ],
)
def test_what_does_not_fit_is_aborted(answers: list[str], why: str) -> None:
    read = SdoTransfer(0x6041)
    read.first()
    for answer in answers[:-1]:
        read.hear(bytes.fromhex(answer))
    with pytest.raises(TransferGarbled, match=why) as error:
        read.hear(bytes.fromhex(answers[-1]))
    assert error.value.abort[0] == 0x80
    assert error.value.abort[1:4] == b"\x41\x60\x00"


def test_a_drive_that_goes_on_for_ever_is_aborted() -> None:
    read = SdoTransfer(0x1008)
    read.first()
    read.hear(bytes.fromhex("4008100000000000"))
    for number in range(MOST_BYTES // 7):
        read.hear(bytes([(number & 1) << 4]) + bytes(7))
    with pytest.raises(TransferGarbled, match="more bytes"):
        read.hear(bytes([(MOST_BYTES // 7 & 1) << 4]) + bytes(7))


def test_an_abort_says_its_code_in_words() -> None:
    read = SdoTransfer(0x60C2, 1)
    read.first()
    why = r"a read of 60C2h:01 with abort 06020000h \(there is no such"
    with pytest.raises(TransferAborted, match=why) as error:
        read.hear(bytes.fromhex("80c2600100000206"))
    assert error.value.code == 0x0602_0000


def test_a_late_answer_is_known_by_its_object() -> None:
    read = SdoTransfer(0x6041)
    read.first()
    assert read.is_for_this(bytes.fromhex("4b41600000000000"))
    assert not read.is_for_this(bytes.fromhex("4b64600000000000"))
    assert read.is_for_this(b"\x4b")  # told as what it is


@given(st.lists(st.binary(max_size=8), max_size=20))
def test_no_answer_does_more_than_end_the_transfer(answers: list[bytes]) -> None:
    for transfer in (SdoTransfer(0x6041), SdoTransfer(0x1008, 0, b"long enough")):
        transfer.first()
        for answer in answers:
            try:
                if transfer.hear(answer) is None:
                    break
            except (TransferAborted, TransferGarbled):
                break
