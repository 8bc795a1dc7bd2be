"""Check of codecs: what it lets pass, and what it says of those that are broken."""

import random
import time
from collections.abc import Callable, Sequence
from typing import ClassVar

import pytest

from hil.testing import CheckFailed, check_codec
from hil.testing.checks.codec_check import Decode
from hil.vocab.time import NS_PER_MS

pytestmark = pytest.mark.long

PAUSE_NS = 2 * NS_PER_MS
MOST_BYTES = 32


class Lengths:
    """A good codec: length, text and a checksum; a pause ends what is not whole."""

    def __init__(self) -> None:
        self.held = bytearray()
        self.last_ns = 0

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        if at_ns - self.last_ns > PAUSE_NS:
            self.held.clear()
        if data:
            self.last_ns = at_ns + len(data) * 86_806
        self.held += data
        return list(self.found())

    def found(self) -> list[object]:
        found: list[object] = []
        while self.held:
            length = self.held[0]
            if not 0 < length <= MOST_BYTES:
                del self.held[0]
            elif len(self.held) < length + 2:
                break
            else:
                text, check = bytes(self.held[1 : length + 1]), self.held[length + 1]
                if sum(text) & 0xFF == check:
                    found.append(text)
                    del self.held[: length + 2]
                else:
                    del self.held[0]
        return found


def encode(items: Sequence[object]) -> bytes:
    whole = b""
    for text in items:
        assert isinstance(text, bytes)
        whole += bytes([len(text)]) + text + bytes([sum(text) & 0xFF])
    return whole


TEXTS = ([b"hello"], [b"a"], [b"one", b"two"], [bytes(range(200, 200 + MOST_BYTES))])
MESSAGES = {encode(texts): texts for texts in TEXTS}


class Forgets(Lengths):
    """Codec that forgets what it has begun when a piece ends."""

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        found = super().__call__(data, at_ns)
        self.held.clear()
        return found


class Blames(Lengths):
    """Codec that raises an error where a length is none."""

    def found(self) -> list[object]:
        if self.held and not 0 < self.held[0] <= MOST_BYTES:
            raise ValueError("bad length")
        return super().found()


class Shares(Lengths):
    """Codec with one buffer for all its instances."""

    ours: ClassVar[bytearray] = bytearray()

    def __init__(self) -> None:
        super().__init__()
        self.held = Shares.ours


class Hoards(Lengths):
    """Codec that keeps all that it ever got."""

    def __init__(self) -> None:
        super().__init__()
        self.all = bytearray()

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        self.all += data
        return super().__call__(data, at_ns)


class Looks(Lengths):
    """Codec that takes the computer's time for the line's."""

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        return super().__call__(data, time.monotonic_ns())


class Begins(Lengths):
    """Codec that takes each line's time to begin at 0."""

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        return super().__call__(data, at_ns) if at_ns < 1_000 * PAUSE_NS else []


class Gambles(Lengths):
    """Codec that loses a byte now and then."""

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        return super().__call__(data if random.random() < 0.8 else data[1:], at_ns)


class Invents(Lengths):
    """Codec that finds something in silence."""

    def __call__(self, data: bytes, at_ns: int) -> list[object]:
        return super().__call__(data, at_ns) or ([] if data else ["still nothing"])


class Sulks(Lengths):
    """Codec that reads nothing more after the first error."""

    is_offended = False

    def found(self) -> list[object]:
        self.is_offended |= bool(self.held) and self.held[0] > MOST_BYTES
        if self.is_offended:
            self.held.clear()
        return super().found()


class Unchecked(Lengths):
    """Codec that finds the checksum in its texts."""

    def found(self) -> list[object]:
        return [bytes(text) + b"!" for text in super().found() if isinstance(text, bytes)]


BROKEN: dict[Callable[[], Decode], tuple[str, str]] = {
    Forgets: ("chunking", "uncut"),
    Blames: ("garbage", "ValueError: bad length"),
    Shares: ("reset", "when another reader had"),
    Hoards: ("limits", "it keeps"),
    Looks: ("time", "the computer's clock"),
    Begins: ("time", "when all comes later"),
    Gambles: ("replay", "otherwise the second time"),
    Invents: ("silence", "nothing came"),
    Sulks: ("garbage", "does not find"),
    Unchecked: ("message", "instead of"),
}


@pytest.mark.thorough
def test_a_good_codec_passes() -> None:
    check_codec(Lengths, MESSAGES, encode=encode)


@pytest.mark.thorough
@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.__name__)
def test_a_broken_one_is_found_by_the_word_for_it(broken: Callable[[], Decode]) -> None:
    word, said = BROKEN[broken]
    with pytest.raises(CheckFailed) as failed:
        check_codec(broken, MESSAGES)
    (finding,) = [each for each in failed.value.findings if each.startswith(f"{word}: ")]
    assert said in finding


def test_an_encoder_is_held_to_the_messages() -> None:
    with pytest.raises(CheckFailed, match=r"message: .* is encoded as") as failed:
        check_codec(Lengths, MESSAGES, encode=lambda items: encode(items)[:-1] + b"x")
    assert failed.value.words == {"message"}


def test_what_reads_a_reliable_stream_need_not_find_its_way_back() -> None:
    check_codec(Sulks, MESSAGES, recovers=False)


def test_without_messages_nothing_is_checked_and_that_is_said() -> None:
    with pytest.raises(CheckFailed, match="message: there is none"):
        check_codec(Lengths, {})
