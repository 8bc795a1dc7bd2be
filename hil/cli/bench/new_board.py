"""Files of a new board, ``hil profile new``: they run, and pass their tests, as they are. The page
``docs/how-to/add-a-profile.md`` shows them."""

from string import Template

FILES = {
    "board.py": '''\
"""Profile of $TITLE."""

from hil.vocab.profile import Example, Profile
from hil.vocab.verbs import Role, Verb

from .firmware import $CLASS


def count(board: $CLASS) -> dict[str, int]:
    return {"count": board.count}


PROFILE = Profile(
    firmware=$CLASS,
    verbs=(Verb("count", "say how many lines it has printed", run=count, role=Role.VIEWER),),
    examples=(Example(types=b"?", answer=b"\\r\\n", within_ms=10),),
)
''',
    "profile.yaml": """\
# $TITLE: its numbers, each with its source.
name: $NAME
title: $TITLE
uarts:
  main:
    baud: 9600 # 8N1; without a baud bytes take no time, as over USB
""",
    "firmware.py": '''\
"""Program of the $NAME: a line each second, and one at once for every '?'."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main
from hil.vocab.time import NS_PER_S


class $CLASS:
    """One power-up."""

    def __init__(self, board: Board) -> None:
        self._uart = board.uart
        self.count = 0

    def main(self) -> Main:
        """Run the board's setup() and loop(): what it waits for is yielded, all else are plain calls."""
        self._uart.write(b"$NAME\\r\\n")
        while True:
            is_asked = yield ByteAvailable(timeout_ns=NS_PER_S)
            if is_asked and self._uart.read() != ord("?"):
                continue
            self.count += 1
            self._uart.write(f"{self.count}\\r\\n".encode())

    def interrupt(self, event: CoreEvent) -> None:
        """Ignore the core's events: none means anything to this board."""
''',
    "tests/test_$NAME.py": '''\
"""$TITLE at its terminal: bytes in, bytes out, at what time."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.testing import Bench, check_profile

BOARD = Path(__file__).parents[1]


@pytest.fixture
def bench() -> Iterator[Bench]:
    config = {"bench": "t", "profile_path": [BOARD.parent], "devices": {"a1": {"profile": BOARD.name}}}
    with Bench(config) as made:
        yield made


def test_a_line_each_second_and_on_demand(bench: Bench) -> None:
    bench.run(ms=1500)
    bench.port("a1").write(b"x?")
    bench.run(ms=600)
    assert bench.port("a1").read_timed() == [
        (0, b"$NAME\\r\\n"),
        (1_000_000_000, b"1\\r\\n"),
        (1_502_083_333, b"2\\r\\n"),  # two characters of ten bits later
    ]
    assert bench.device("a1").do("count")["count"] == 2


def test_it_passes_the_checks_of_all_boards() -> None:
    check_profile(BOARD)
''',
    "README.md": """\
# $TITLE

A board for hil: `firmware.py` is its program, `profile.yaml` has its numbers with their sources, and
`board.py` says what hil asks for.

```text
hil profile check $FOLDER
python -m pytest $FOLDER
```

In a configuration, with the folder that this one is in:

```yaml
bench: try
profile_path: [$PARENT]
devices:
  a1:
    profile: $NAME
```

Not modelled: say here what the real board does besides.
""",
}
"""Texts by the files' names in the board's folder."""


def files_of(name: str, parent: str) -> dict[str, str]:
    """Write the files of a new board by their names; ``parent``: the folder that the board's is in."""
    words = {
        "NAME": name,
        "CLASS": "".join(part.capitalize() for part in name.split("_")),
        "TITLE": f"Board {name}",
        "PARENT": parent,
        "FOLDER": name if parent == "." else f"{parent}/{name}",
    }
    return {
        Template(file).substitute(words): Template(text).substitute(words) for file, text in FILES.items()
    }
