"""Any bytes at any time: afterwards a carriage return gives a prompt, or the board is in a known dead end.

``HIL_FUZZ`` sets how many inputs are tried (2,500; ``make fuzz``: a million), ``HIL_FUZZ_SEED`` where
they start.
"""

import os
import random
from collections.abc import Callable

import pytest

from device_profiles.sac.network import DC1, DC2
from hil.testing import Bench

pytestmark = pytest.mark.long

CASES = int(os.environ.get("HIL_FUZZ", "2500"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
CONFIG = {"bench": "fuzz", "devices": {"s1": {"profile": "sac", "port": "memory"}}}
NUMBERS = (0, 1, 2, 8, 10, 30, 31, 99, 100, 200, 255, 256, 999, 1000, 3000, 65535, 65536, 2**32 - 1, 2**32)
LETTERS = "mMaAdDvVlLxXsSnNyqQzZgGcCbB$"
QUIET_MS, ROUNDS = 50, 500


class Grammar:
    """Lines that mean something, mostly."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance

    def number(self) -> str:
        chance = self._chance
        whole = str(chance.choice(NUMBERS) if chance.random() < 0.7 else chance.randrange(300))
        return whole + (f".{chance.randrange(1000)}" if chance.random() < 0.1 else "")

    def maybe_number(self) -> str:
        return self.number() if self._chance.random() < 0.9 else ""

    def attributes(self) -> str:
        letters = self._chance.choices(["v", "vc", "a", "d", "l", "u", "t", "f", "p", "s", "m", "?"], k=4)
        return "".join(letter + self.maybe_number() for letter in letters[: self._chance.randrange(5)])

    def motion(self) -> str:
        return self._chance.choice(["m", "m-", "xm", "xm-"]) + self.maybe_number() + self.attributes()

    def unary(self) -> str:
        return self._chance.choice(["a", "d", "v", "vc", "vd", "x", "y", "z", "g", "b"]) + self.maybe_number()

    def stop(self) -> str:
        return self._chance.choice(["s", "S", "n", "N", "l", "y"])

    def loop(self) -> str:
        return self._chance.choice(["ls", "lf", "ln", "la", "l", "xl"]) + self.maybe_number()

    def queue(self) -> str:
        if self._chance.random() < 0.5:
            return "q" + self.number() + self._chance.choice(["", "m", "m-"]) + self.attributes()
        return self._chance.choice(["q", "qs", "qr", "qc", "qp", "xp", "xd", "x", "cf", "cc"])

    def edit(self) -> str:
        return f"{self.number()}{self._chance.choice([',', 'm', ''])}{self.maybe_number()}{self.attributes()}"

    def system(self) -> str:
        chance = self._chance
        if chance.random() < 0.4:
            return "$" + chance.choice("EFHKLOPRRRUn") + self.maybe_number()
        letter = chance.choice("ABCDEFGHIJKLMNOabcdefghijkmnuU")
        return chance.choice(["$C", ""]) + letter + self.maybe_number()

    def noise(self) -> str:
        size = self._chance.randrange(12)
        return "".join(chr(self._chance.randrange(256)) for _ in range(size))

    def letters(self) -> str:
        return "".join(self._chance.choices(LETTERS + "0123456789.-+, \b", k=self._chance.randrange(8)))

    def line(self) -> bytes:
        kinds: list[Callable[[], str]] = [
            self.motion, self.motion, self.unary, self.stop, self.loop, self.queue, self.edit, self.system,
            self.system, self.noise, self.letters,
        ]  # fmt: skip
        text = self._chance.choice(kinds)() + self._chance.choice(["\r"] * 8 + ["\n", "\r\n", ""])
        return text.encode("latin-1")


class Victim:
    """A board whose RST is held low, so that each case begins from the factory's settings."""

    def __init__(self) -> None:
        self.bench = Bench(CONFIG)
        self.port = self.bench.port("s1")
        self.device = self.bench.device("s1")
        self.device.pin("RST").set(0)

    def cold_start(self) -> None:
        """Reset the board, and run to its prompt; at the slowest speed that may have been set, the 66
        characters take 1.4 s more."""
        self.device.reset()
        self.bench.run(ms=1010)
        if not (sent := self.read()).endswith(b"SAC>"):
            self.bench.run(ms=1600)
            sent += self.read()
        assert sent.endswith(b"SAC 1.0\r\nSAC>")

    def read(self) -> bytes:
        assert self.device.failed is None
        self.port.timeline.clear()
        return self.port.read().translate(None, DC1 + DC2)  # soft_ops, at any time

    def quieten(self) -> None:
        """Run until the board has nothing more to say: its output is on the line, and nothing follows."""
        for _ in range(ROUNDS):
            self.bench.run_until(ms=max(self.bench.now_ns, self.port.line_free_ns) / 1e6 + QUIET_MS)
            if not self.read():
                return
        raise AssertionError("it never ends")

    def survive(self, pieces: list[tuple[float, bytes]]) -> None:
        self.cold_start()
        for gap_ms, data in pieces:
            self.port.write(data)
            self.bench.run(ms=gap_ms)
        self.quieten()
        self.port.write(b"\r")
        self.bench.run(ms=200)  # 7 characters at the slowest speed that can be set
        if not self.read().endswith(b"SAC>"):
            assert "terminal" in self.device.notes, "silent, and no dead end"


def case(number: int) -> list[tuple[float, bytes]]:
    """Pairs of (ms until the next, bytes), the same for the same number."""
    chance = random.Random(f"{SEED}/{number}")
    grammar = Grammar(chance)
    gaps = (0.0, 1.0, 20.0, 200.0)
    return [(chance.choice(gaps), grammar.line()) for _ in range(chance.randrange(1, 8))]


@pytest.mark.thorough
def test_any_bytes_leave_a_board_that_answers() -> None:
    for number in range(CASES):
        if number % 100 == 0:  # a bench keeps all edges of its outputs
            victim = Victim()
        try:
            victim.survive(case(number))
        except BaseException as error:
            error.add_note(f"case {number} of seed {SEED}: {case(number)!r}")
            raise


def test_the_same_bytes_give_the_same_answers() -> None:
    def play() -> list[bytes]:
        victim, answers = Victim(), []
        for number in range(60):
            victim.cold_start()
            for gap_ms, data in case(number):
                victim.port.write(data)
                victim.bench.run(ms=gap_ms)
            victim.bench.run(ms=300)
            answers.append(victim.read())
        return answers

    assert play() == play()
