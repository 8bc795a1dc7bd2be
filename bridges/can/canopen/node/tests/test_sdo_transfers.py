"""SDO transfers of all sizes, with losses, by a client that is written again from the standard."""

from binascii import crc_hqx
from collections.abc import Callable, Collection
from random import Random

import pytest
from canopen_rig import Rig
from hypothesis import given
from hypothesis import strategies as st

REQUEST, ANSWER = 0x605, "585#"
BULK = "012000"
ABORT = 0x80


class Client:
    """Client of one node. ``loses`` says of each segment that it sends whether it gets lost."""

    def __init__(self, rig: Rig, loses: Callable[[], bool] = lambda: False) -> None:
        self.rig = rig
        self._loses = loses
        rig.take()

    def ask(self, text: str) -> list[bytes]:
        """Send a frame; the node's answers."""
        answers = self.rig.hear(f"{REQUEST:03X}#{text.ljust(16, '0')}")
        assert all(answer.startswith(ANSWER) for answer in answers), answers
        found = [bytes.fromhex(answer[len(ANSWER) :]) for answer in answers]
        assert all(len(answer) == 8 and answer[0] != ABORT for answer in found), answers
        return found

    def download_by_segments(self, data: bytes, *, says_size: bool) -> None:
        size = len(data).to_bytes(4, "little").hex() if says_size else ""
        assert self.ask(f"{0x20 | says_size:02X}{BULK}{size}") == [bytes.fromhex(f"60{BULK}00000000")]
        for at in range(0, max(len(data), 1), 7):
            segment, toggle = data[at : at + 7], at // 7 % 2 << 4
            command = toggle | 7 - len(segment) << 1 | (at + 7 >= len(data))
            assert self.ask(f"{command:02X}{segment.hex()}") == [bytes((0x20 | toggle, *bytes(7)))]

    def upload_by_segments(self) -> bytes:
        (head,) = self.ask(f"40{BULK}")
        if head[0] & 2:
            return head[4 : 8 - (head[0] >> 2 & 3)]
        assert head[0] == 0x41
        data, toggle, is_last = b"", 0, 0
        while not is_last:
            (answer,) = self.ask(f"{0x60 | toggle:02X}")
            assert answer[0] & 0xF0 == toggle
            data += answer[1 : 8 - (answer[0] >> 1 & 7)]
            toggle ^= 0x10
            is_last = answer[0] & 1
        assert len(data) == int.from_bytes(head[4:], "little")
        return data

    def download_by_blocks(self, data: bytes, *, has_crc: bool) -> None:
        size = len(data).to_bytes(4, "little").hex()
        ((first, *_, block_size, _, _, _),) = self.ask(f"{0xC2 | has_crc << 2:02X}{BULK}{size}")
        assert first == 0xA0 | has_crc << 2
        segments = [data[at : at + 7] for at in range(0, len(data), 7)] or [b""]
        done = 0
        while done < len(segments):
            block = segments[done : done + block_size]
            answers = []
            for number, segment in enumerate(block, 1):
                is_last = done + number == len(segments)
                # The last of a block is never lost: without it the server waits for the time-out.
                if number == len(block) or not self._loses():
                    answers += self.ask(f"{number | is_last << 7:02X}{segment.hex()}")
            ((first, acknowledged, block_size, *_),) = answers
            assert first == 0xA2
            done += acknowledged
        unused = 7 - len(segments[-1])
        crc = crc_hqx(data, 0).to_bytes(2, "little").hex() if has_crc else ""
        assert self.ask(f"{0xC1 | unused << 2:02X}{crc}") == [bytes((0xA1, *bytes(7)))]

    def upload_by_blocks(self, sizes: Callable[[], int], *, has_crc: bool) -> bytes:
        size = sizes()
        (head,) = self.ask(f"{0xA0 | has_crc << 2:02X}{BULK}{size:02X}")
        assert head[0] == 0xC2 | has_crc << 2
        answers = self.ask("A3")
        data = b""
        while True:
            assert 1 <= len(answers) <= size
            assert [answer[0] & 0x7F for answer in answers] == [*range(1, len(answers) + 1)]
            is_whole = bool(answers[-1][0] & 0x80)
            assert is_whole or len(answers) == size
            got = next((at for at in range(len(answers)) if self._loses()), len(answers))
            data += b"".join(answer[1:] for answer in answers[:got])
            is_whole = is_whole and got == len(answers)
            size = sizes()
            answers = self.ask(f"A2{got:02X}{size:02X}")
            if is_whole:
                break
        ((first, low, high, *_),) = answers
        assert first & 0xE3 == 0xC1
        data = data[: len(data) - (first >> 2 & 7)]
        assert low | high << 8 == (crc_hqx(data, 0) if has_crc else 0)
        assert self.ask("A1") == []
        assert len(data) == int.from_bytes(head[4:], "little")
        return data


def some_bytes(size: int) -> bytes:
    return bytes((i * 37 + size) & 0xFF for i in range(size))


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize(
    "sizes", [range(start, start + 500) for start in (0, 500, 1000, 1500)] + [(2000,)], ids=str
)
def test_all_sizes(sizes: Collection[int]) -> None:
    rig = Rig()
    client = Client(rig)
    for size in sizes:
        data, other = some_bytes(size), some_bytes(size)[::-1]
        client.download_by_blocks(data, has_crc=size % 3 > 0)
        assert rig.node.value(0x2001, 0) == data
        assert client.upload_by_blocks(lambda size=size: size % 127 + 1, has_crc=size % 2 > 0) == data
        client.download_by_segments(other, says_size=size % 2 > 0)
        assert client.upload_by_segments() == other


@pytest.mark.thorough
@pytest.mark.long
@given(st.integers(0, 3000), st.randoms(use_true_random=False), st.floats(0, 0.6), st.booleans())
def test_blocks_with_losses(size: int, chance: Random, rate: float, has_crc: bool) -> None:
    rig = Rig()
    client = Client(rig, lambda: chance.random() < rate)
    data = some_bytes(size)
    client.download_by_blocks(data, has_crc=has_crc)
    assert rig.node.value(0x2001, 0) == data
    assert client.upload_by_blocks(lambda: chance.randint(1, 127), has_crc=has_crc) == data


def test_a_value_stays_as_it_was_when_the_transfer_began() -> None:
    rig = Rig()
    client = Client(rig)
    client.download_by_segments(bytes(100), says_size=True)
    (head,) = client.ask(f"40{BULK}")
    rig.node.set_value(0x2001, 0, b"another")
    data = b"".join(client.ask("70" if at % 2 else "60")[0][1:] for at in range(15))
    assert (head[4], data) == (100, bytes(105))


def test_what_is_longer_than_the_device_takes() -> None:
    rig = Rig()
    client = Client(rig)
    client.download_by_blocks(bytes(65536), has_crc=True)
    assert rig.hear(f"605#21{BULK}01000100") == [f"585#80{BULK}12000706"]
    assert rig.hear(f"605#C0{BULK}00000000") == [f"585#A0{BULK}7F000000"]
    segments = 0
    while f"585#80{BULK}12000706" not in rig.hear(f"605#{segments % 127 + 1:02X}00000000000000"):
        segments += 1
    assert segments == 65536 // 7 + 1
    assert rig.node.value(0x2001, 0) == bytes(65536)
