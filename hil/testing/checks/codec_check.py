"""Check of a codec: a reader of a line's bytes."""

import gc
import time
import tracemalloc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from random import Random
from unittest.mock import patch

from hil.testing.checks.findings import CheckFailed, cuts, raised, shown
from hil.vocab.framing import Framing
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

Decode = Callable[[bytes, int], Sequence[object]]
"""Reads bytes that stand back to back from a time in nanoseconds on; answers what it has found with them. No
bytes: nothing has come until that time."""

CHARACTER_NS = 86_806
"""One character at 115200 baud."""
PAUSE_NS = 10 * NS_PER_MS
KEPT_BYTES = 65_536
GARBAGE_BYTES = 2_000
ENDLESS_BYTES = 1 << 17
LATER_NS = 7_000 * NS_PER_S + 1
_CLOCKS = ("time", "time_ns", "monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns")


def check_codec(
    make: Callable[[], Decode],
    messages: Mapping[bytes, Sequence[object]],
    *,
    encode: Callable[[Sequence[object]], bytes] | None = None,
    recovers: bool = True,
    character_ns: int = CHARACTER_NS,
    pause_ns: int = PAUSE_NS,
    kept_bytes: int = KEPT_BYTES,
) -> None:
    """Check a codec. ``make``: makes a reader that has read nothing. ``messages``: bytes, and what is found
    in them; ``encode``: what makes the bytes of that again. ``character_ns`` and ``pause_ns``: of the line,
    between two characters and two messages. ``kept_bytes``: maximum memory for what has not ended.
    ``recovers``: whether it finds a message again after garbage; not so where a line is reliable.

    - message: in each is found what ``messages`` says, and ``encode`` makes the same bytes of it.
    - chunking: the same is found however the bytes are cut.
    - time: nothing depends on when it begins, and the computer's clock is not asked.
    - silence: where nothing comes, nothing is found.
    - garbage: any bytes are read without an error, and the message after them is found.
    - reset: a new reader knows nothing of what another has read.
    - replay: the same bytes at the same times are read alike.
    - limits: what never ends is not kept.

    Raises:
        CheckFailed: with all that is wrong.
    """
    check = _CodecCheck(make, messages, character_ns, pause_ns)
    found = [
        *check.of("message", check.messages_are_read(encode)),
        *check.of("chunking", check.cuts_change_nothing()),
        *check.of("time", check.times_change_nothing()),
        *check.of("silence", check.silence_is_nothing()),
        *check.of("garbage", check.garbage_is_survived(recovers)),
        *check.of("reset", check.readers_are_apart()),
        *check.of("replay", check.it_is_the_same_again()),
        *check.of("limits", check.nothing_endless_is_kept(kept_bytes)),
    ]
    if found:
        raise CheckFailed("the codec", found)


def framing_reader(framing: Framing, baud: int) -> Callable[[], Decode]:
    """Let a framing be checked as a codec, at a speed: an item is found as (text, is_packet, fault, origin).
    ``character_ns`` of the check has to be that of the speed."""

    def make() -> Decode:
        splitter = framing.splitter()

        def decode(data: bytes, at_ns: int) -> list[object]:
            now_ns = SimTimeNs(at_ns)
            items = splitter.burst(data, now_ns, baud).items if data else splitter.silence(now_ns)
            return [(framing.text(item), item.is_packet, item.fault, item.origin) for item in items]

        return decode

    return make


class _CodecCheck:
    def __init__(
        self,
        make: Callable[[], Decode],
        messages: Mapping[bytes, Sequence[object]],
        one_ns: int,
        pause_ns: int,
    ) -> None:
        self._make = make
        self._messages = messages
        self._one_ns, self._pause_ns = one_ns, pause_ns
        self._random = Random(0)

    @staticmethod
    def of(word: str, findings: Iterator[str]) -> Iterator[str]:
        """The first finding, and an error where there is one instead."""
        try:
            first = next(findings, None)
        except Exception as error:  # theirs: it is what the check is for
            first = f"it raised {raised(error)}"
        if first is not None:
            yield f"{word}: {first}"

    def _read(self, decode: Decode, pieces: Sequence[bytes], at_ns: int = 0) -> list[object]:
        """Read pieces that stand back to back, and the silence after them."""
        found: list[object] = []
        for piece in pieces:
            found += decode(piece, at_ns)
            at_ns += len(piece) * self._one_ns
        return [*found, *decode(b"", at_ns + self._pause_ns)]

    def _read_all(self, decode: Decode, begin_ns: int = 0) -> list[object]:
        """Read all messages, one after the other."""
        found, at_ns = [], begin_ns
        for raw in self._messages:
            found += self._read(decode, [raw], at_ns)
            at_ns += len(raw) * self._one_ns + 2 * self._pause_ns
        return found

    def messages_are_read(self, encode: Callable[[Sequence[object]], bytes] | None) -> Iterator[str]:
        if not self._messages:
            yield "there is none to check with"
        for raw, wanted in self._messages.items():
            if (found := self._read(self._make(), [raw])) != list(wanted):
                yield f"in {shown(raw)} it finds {shown(found)} instead of {shown(list(wanted))}"
            if encode is not None and (made := encode(wanted)) != raw:
                yield f"{shown(list(wanted))} is encoded as {shown(made)} instead of {shown(raw)}"

    def cuts_change_nothing(self) -> Iterator[str]:
        for raw in (*self._messages, b"".join(self._messages)):
            whole = self._read(self._make(), [raw])
            for pieces in cuts(raw, self._random):
                if (found := self._read(self._make(), pieces)) != whole:
                    yield f"in {shown(pieces)} it finds {shown(found)}, uncut {shown(whole)}"

    def times_change_nothing(self) -> Iterator[str]:
        if (found := self._read_all(self._make())) != (later := self._read_all(self._make(), LATER_NS)):
            yield f"it finds {shown(found)}, and {shown(later)} when all comes later"
        asked: list[str] = []
        with _clocks(asked):
            self._read_all(self._make())
        if asked:
            yield f"it asks the computer's clock (time.{asked[0]}); take the time that it is given"

    def silence_is_nothing(self) -> Iterator[str]:
        decode = self._make()
        for at_ns in (0, self._pause_ns, LATER_NS):
            if found := decode(b"", at_ns):
                yield f"nothing came, and it finds {shown(found)}"
        self._read_all(decode, LATER_NS)
        if found := decode(b"", 2 * LATER_NS):
            yield f"all messages were over, and later it finds {shown(found)}"

    def garbage_is_survived(self, recovers: bool) -> Iterator[str]:
        for raw in self._messages:
            wanted = self._read(self._make(), [raw])
            for garbage in (self._random.randbytes(GARBAGE_BYTES), raw[: len(raw) // 2]):
                decode = self._make()
                found = self._read(decode, [garbage])
                if len(found) > len(garbage) + 1:
                    yield f"in {len(garbage)} bytes of it {len(found)} things are found"
                again, at_ns = [], len(garbage) * self._one_ns
                for _ in range(2):
                    at_ns += 2 * self._pause_ns
                    again += self._read(decode, [raw], at_ns)
                    at_ns += len(raw) * self._one_ns
                if recovers and not _has(again, wanted):
                    yield f"after {shown(garbage)} it does not find {shown(raw)} any more, twice sent"

    def readers_are_apart(self) -> Iterator[str]:
        for raw in self._messages:
            half = len(raw) // 2
            for begun, rest in ((raw[:half], raw[half:]), (raw[:half], raw), (raw, raw)):
                wanted = self._read(self._make(), [rest])
                first, second = self._make(), self._make()
                first(begun, 0)
                if (found := self._read(second, [rest], len(begun) * self._one_ns)) != wanted:
                    why = f"when another reader had {shown(begun)} before"
                    yield f"in {shown(rest)} it finds {shown(found)} {why}"

    def it_is_the_same_again(self) -> Iterator[str]:
        stream = 5 * b"".join(self._messages) + self._random.randbytes(GARBAGE_BYTES)
        pieces = cuts(stream, self._random)[1]
        first, again = (self._read(self._make(), pieces) for _ in range(2))
        if first != again:
            at = next((n for n, (a, b) in enumerate(zip(first, again, strict=False)) if a != b), "the end")
            yield f"the same bytes at the same times are read otherwise the second time, from item {at} on"

    def nothing_endless_is_kept(self, kept_bytes: int) -> Iterator[str]:
        beginnings = {raw[: max(len(raw) // 2, 1)] for raw in self._messages} | {b"\xff", b"\0", b"a"}
        for beginning in sorted(beginnings):
            decode, at_ns = self._make(), 0
            decode(beginning, 0)
            endless = beginning[-1:] * 4096
            tracemalloc.start()
            try:
                for _ in range(ENDLESS_BYTES // len(endless)):
                    at_ns += len(endless) * self._one_ns
                    decode(endless, at_ns)
                gc.collect()  # empties Python's own stores of small objects
                kept, _ = tracemalloc.get_traced_memory()
            finally:
                tracemalloc.stop()
            if kept > kept_bytes:
                what = f"{ENDLESS_BYTES} bytes {shown(beginning)}..."
                yield f"of {what} it keeps {kept}, {kept_bytes} are allowed"


def _has(found: Sequence[object], wanted: Sequence[object]) -> bool:
    size = len(wanted)
    return any(list(found[n : n + size]) == list(wanted) for n in range(len(found) - size + 1))


@contextmanager
def _clocks(asked: list[str]) -> Iterator[None]:
    """Note who asks the computer's clock meanwhile."""

    def noted(name: str) -> Callable[[], float]:
        clock: Callable[[], float] = getattr(time, name)

        def ask() -> float:
            asked.append(name)
            return clock()

        return ask

    with ExitStack() as stack:
        for name in _CLOCKS:
            stack.enter_context(patch.object(time, name, noted(name)))
        yield
