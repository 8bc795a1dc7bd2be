"""Checks of all boards: each board of the project passes, and a broken specimen of each kind does not."""

import sys
from pathlib import Path

import pytest

from hil.testing import CheckFailed, check_profile

pytestmark = pytest.mark.long

BOARDS = Path(__file__).parents[3] / "device_profiles"
YAML = """\
name: specimen
title: A board with a mistake
law: mechaduino
motor: nema17-2A
uarts: {main: {baud: 115200}}
axis:
  sense_resistor_ohm: {value: 0.15, unit: ohm, about: Of the driver., source: chosen}
"""
BOARD = """\
import random

from hil.vocab.firmware import ByteAvailable, Commit, Delay
from hil.vocab.profile import Example, Profile

SEEN = []


class Specimen:
    def __init__(self, board):
        self.uart, self.nvm = board.uart, board.nvm

    def main(self):
        self.uart.write(b"here\\r\\n")
        while True:
            yield ByteAvailable()
            byte = self.uart.read()
            %s
            self.uart.write(bytes([byte]))

    def interrupt(self, event):
        pass


PROFILE = Profile(firmware=Specimen)
"""


def specimen(folder: Path, mistake: str, old: str = "%s") -> Path:
    board = folder / "specimen"
    board.mkdir(parents=True)
    (board / "profile.yaml").write_text(YAML)
    (board / "board.py").write_text(BOARD.replace(old, mistake).replace("%s", "pass"))
    return board


@pytest.mark.thorough
@pytest.mark.parametrize(
    "board", sorted(path.parent for path in BOARDS.glob("*/board.py")), ids=lambda b: b.name
)
def test_the_projects_boards_pass(board: Path) -> None:
    check_profile(board)


def test_a_board_without_a_mistake_passes(tmp_path: Path) -> None:
    check_profile(specimen(tmp_path, "pass"))


@pytest.mark.parametrize(
    ("mistake", "old", "said"),
    [
        ("class Spcimen", "class Specimen", "it loads: {board}/board.py:25:28: NameError: name 'Specimen'"),
        ("raise OSError('no')", 'self.uart.write(b"here\\r\\n")', "it powers up: OSError: no"),
        ("byte = 1 // (byte != 7)", "%s", "garbage does not stop it: ZeroDivisionError"),
        (
            "self.uart.write(b'%d' % random.getrandbits(20))",
            "%s",
            "the same bytes at the same times give the same answers: at main once b'",
        ),
        (
            "SEEN.append(byte); byte ^= len(SEEN) & 0xFF",
            "%s",
            "the same bytes at the same times give the same",
        ),
        ("SEEN.append(byte); byte ^= len(SEEN) & 0xFF", "%s", "a log of it replays identically: "),
        (
            "SEEN.append(1); self.uart.write(b'start %d' % len(SEEN))",
            'self.uart.write(b"here\\r\\n")',
            "after off and on it does as at first: at main once b'start ",
        ),
        (
            "SEEN.append(1); self.uart.write(b'start %d' % len(SEEN))",
            'self.uart.write(b"here\\r\\n")',
            "it does the same however time passes: at main once b'start ",
        ),
        (
            "SEEN.append(byte); byte ^= len(SEEN) & 0xFF",
            "%s",
            "it does the same however its bytes are cut into pieces: at main once b'",
        ),
        (
            "SEEN.append(byte); byte = byte if len(SEEN) < 4_000 else 1 // 0",
            "%s",
            "a flood does not stop it: ZeroDivisionError",
        ),
        (
            "firmware=Specimen, examples=(Example(types=b'a', answer=b'b'),)",
            "firmware=Specimen",
            "its examples are answered, each time and in a replay: b'a' is answered within 1000 ms by b'a'",
        ),
        (
            "firmware=Specimen, examples=(Example(types=b'ab', answer=b'ab', within_ms=0.2),)",
            "firmware=Specimen",
            "its examples are answered, each time and in a replay: b'ab' is answered within 0.2 ms by b'a'",
        ),
    ],
)
def test_a_mistake_is_said_by_the_check_it_fails(tmp_path: Path, mistake: str, old: str, said: str) -> None:
    board = specimen(tmp_path, mistake, old)
    with pytest.raises(CheckFailed) as caught:
        check_profile(board)
    lines = caught.value.findings
    assert any(line.startswith(said.format(board=board)) for line in lines), lines


def test_a_field_that_no_axis_has_is_said(tmp_path: Path) -> None:
    board = specimen(tmp_path, "firmware=Specimen, shown_first=('r', 'speed')", "firmware=Specimen")
    with pytest.raises(AssertionError, match="fields of an axis: there is none named speed"):
        check_profile(board)


def test_a_firmware_that_never_yields_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["hil.testing.profile_check"], "TURN_S", 0.2)
    board = specimen(tmp_path, "while True: pass", 'self.uart.write(b"here\\r\\n")')
    with pytest.raises(
        AssertionError, match=r"it powers up: FirmwareHung: one step took more than 0\.2 s: it has to yield"
    ):
        check_profile(board)
