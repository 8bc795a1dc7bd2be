"""Any dialogue: afterwards the board answers as before, and nothing of it has failed.

``HIL_FUZZ`` sets how many dialogues are tried (40; ``make fuzz``: 100,000; HIL_FUZZ=1000000: a million),
``HIL_FUZZ_SEED`` where they start.
"""

import os
from random import Random

from hil.testing import Bench

DIALOGUES = int(os.environ.get("HIL_FUZZ", "40"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
DIALOGUES_OF_A_BOARD = 50
NAMES = (
    *("LED", "HELP", "ECHO", "ENABLE", "DISABLE", "SETUP", "POWER", "KNOB", "STEP", "CHECKSUM", "MEM", "SET"),
    *("GET", "MOVETO", "LOG", "INFO", "PRINT", "PRINTLN", "XYZ", "CHECKSUMABC", "=", "chk=1"),
)
WORDS = (
    *(
        "on",
        "off",
        "all",
        "list",
        "reset",
        "blink",
        "setup",
        "servo",
        "encoder",
        "loop",
        "test",
        "0",
        "3",
        "5",
        "6",
    ),
    *(
        "7",
        "-1",
        "1e1",
        "70000",
        "nan",
        "inf",
        "-0.0",
        "abc",
        "min=-20",
        "max=50",
        "null=3",
        "speed=0",
        "acc=-5",
    ),
    *(
        "P=10",
        "I=1",
        "D=0",
        "min",
        "=",
        "==",
        "=5",
        "P=",
        "chk=",
        "chk=77",
        "180",
        "360.5",
        "99999999999",
        "0x1F",
    ),
)
QUIET_MS = 20.0
LONGEST_MS = 20_000.0
"""More than ENABLE of an arm whose servos are mute takes, and a long line at the printer."""


def line(random: Random) -> bytes:
    """A line that means something, or nothing."""
    kind = random.random()
    if kind < 0.1:
        return random.randbytes(random.randrange(200))
    words = [random.choice(NAMES), *random.choices(WORDS, k=random.randrange(10))]
    if kind < 0.2:
        words = [
            "MOVETO",
            *(str(random.randint(-400, 400)) for _ in range(7)),
            str(random.randrange(20, 3000)),
        ]
    text = (" " * random.choice((1, 1, 1, 3))).join(words).encode()
    if kind > 0.95:
        place = random.randrange(len(text) + 1)
        text = text[:place] + random.randbytes(3) + text[place:]
    return text + random.choice((b"\r", b"\r", b"\r", b"\r\n", b"\n", b""))


def test_any_dialogue_leaves_a_board_that_answers() -> None:
    for first in range(0, DIALOGUES, DIALOGUES_OF_A_BOARD):
        random = Random(SEED * 1_000_003 + first)
        paced = {} if random.random() < 0.5 else {"baud": None}
        faults = [{"fault": "bus_no_answer", "target": f"w1.{random.choice(('hip', 'wrist', 'hand'))}"}]
        config = {"bench": "fuzz", "devices": {"w1": {"profile": "walter"} | paced}}
        with Bench(config | {"faults": faults if random.random() < 0.3 else []}) as bench:
            bench.run(ms=1000)
            for number in range(min(DIALOGUES_OF_A_BOARD, DIALOGUES - first)):
                for _ in range(random.randrange(1, 6)):
                    bench.port("w1").write(line(random))
                    bench.run(ms=random.choice((0.0, 3.0, 100.0)))
                bench.port("w1").write(b"\r")
                ends(bench, f"dialogue {first + number} of seed {SEED}")


def ends(bench: Bench, name: str) -> None:
    """Wait until the board answers."""
    bench.run(ms=QUIET_MS)
    bench.port("w1").read()
    heard, waited_ms = b"", 0.0
    while not heard.endswith(b"=here=>ok\r\n>"):
        assert waited_ms < LONGEST_MS, name
        if waited_ms % 2000 == 0:
            bench.port("w1").write(b"\rCHECKSUM off\rECHO =here=\r")
        bench.run(ms=QUIET_MS)
        waited_ms += QUIET_MS
        assert bench.device("w1").failed is None, name
        heard += bench.port("w1").read()
