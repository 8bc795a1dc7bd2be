"""``hil profile check`` says file and line of what a board's code raised, in whichever handler."""

from pathlib import Path

import pytest

from hil.testing import CheckFailed, check_profile

PROFILE = "name: odd\ntitle: Odd\nuarts: {main: {baud: 9600}, log: {}}\n"
BOARD = """
from hil.vocab.profile import Profile, UartSpec
from hil.vocab.verbs import Verb
from .firmware import Odd, boom
PROFILE = Profile(
    firmware=Odd,
    uarts={"main": UartSpec(about="terminal"), "log": UartSpec(about="log")},
    verbs=(Verb("boom", "fail", run=boom),),
)
"""
FIRMWARE = """
import json
from hil.firmware.board_handlers import BoardHandlers
from hil.vocab.firmware import Delay

class Odd(BoardHandlers):
    TICK_NS = 10_000_000

    def setup(self):
        IN_SETUP

    def received(self, uart, data):
        IN_RECEIVED

    def tick(self):
        IN_TICK

    def again(self, deeper):
        return self.again(deeper + 1)

def boom(board):
    IN_VERB
"""
LINES = {"IN_SETUP": 10, "IN_RECEIVED": 13, "IN_TICK": 16, "IN_VERB": 22}
WRITES = "write() of a UART takes bytes, as in b'ok', not"


def firmware(**bodies: str) -> str:
    """Text of a firmware whose handlers do this, and nothing else."""
    text = FIRMWARE
    for name in LINES:
        text = text.replace(name, bodies.get(name, "pass"))
    return text


def said(tmp_path: Path, firmware: str) -> str:
    folder = tmp_path / "odd"
    folder.mkdir()
    for name, text in {"profile.yaml": PROFILE, "board.py": BOARD, "firmware.py": firmware}.items():
        (folder / name).write_text(text)
    with pytest.raises(CheckFailed) as failed:
        check_profile(folder)
    return str(failed.value)


@pytest.mark.parametrize(
    ("handler", "line", "why"),
    [
        ("IN_SETUP", "self.vlaue", "AttributeError: 'Odd' object has no attribute 'vlaue'"),
        (
            "IN_RECEIVED",
            'json.loads("{")',
            "JSONDecodeError: Expecting property name",
        ),
        ("IN_RECEIVED", "self.board.uarts['main'].write('ok')", f"TypeError: {WRITES} str"),
        ("IN_TICK", "self.board.uart.write(7)", f"TypeError: {WRITES} int"),
        (
            "IN_TICK",
            "self.board.tell('level', 'high')",
            "TypeError: tell('level', ...) takes a number",
        ),
        ("IN_TICK", "raise SystemExit(1)", "SystemExit: 1"),
        ("IN_VERB", "1 / 0", "boom: ZeroDivisionError: division by zero"),
    ],
)
def test_what_a_handler_raises(tmp_path: Path, handler: str, line: str, why: str) -> None:
    told = said(tmp_path, firmware(**{handler: line}))
    assert why in told
    assert f"(odd/firmware.py:{LINES[handler]})" in told


def test_what_goes_too_deep(tmp_path: Path) -> None:
    assert "(odd/firmware.py:19)" in said(tmp_path, firmware(IN_TICK="self.again(0)"))


def test_an_answer_that_cannot_be_handed_on(tmp_path: Path) -> None:
    told = said(tmp_path, firmware(IN_VERB="return 5"))
    assert "boom: TypeError: verb boom: it answers int, and no mapping of names" in told


def test_a_yield_of_something_else(tmp_path: Path) -> None:
    main = "    def main(self):\n        while True:\n            yield 5\n\n    def again("
    told = said(tmp_path, firmware().replace("    def again(", main))
    assert "the main program yielded 5, which is no request (odd/firmware.py:20)" in told
