"""Views of commands in narrow terminals, from answers of one bench that is served."""

import fcntl
import os
import pty
import re
import shutil
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator
from contextlib import suppress

import pytest

from hil.testing import ServedBench, live

pytestmark = pytest.mark.long
CONFIG = {
    "bench": "views",
    "speed": 20,
    "devices": {"m1": {"profile": "mechaduino"}, "s1": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}},
    "bridges": {"modbus": {"listen": "127.0.0.1:0", "units": {"m1": 1}}},
}
HIL = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"
BAR = "\u2501"
VIEWS = (
    "list",
    "list --programs",
    "status",
    "status m1",
    "fault kinds",
    "fault kinds encoder_slip",
    "docs",
    "line nodes bus0.master --addresses 85",
    "modbus map m1",
    "doctor",
    "recordings --state-dir STATE",
    "parity --list",
    "parity sac/identify --tolerance 5s --at PORT",
    "export RECORDING m1.position_deg",
)
ELSEWHERE = ("docs", "recordings", "parity", "export")
"""Commands that ask no bench."""
MAY_FAIL = ("doctor",)
"""Commands whose exit code says what they found here."""


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(CONFIG) as made:
        kept = made.folder / "kept" / "views" / "recordings"
        kept.mkdir(parents=True)
        for second in range(3):
            shutil.copy(made.recording_file, kept / f"2026-01-02T03-04-0{second}Z.hil.gz")
        yield made


@pytest.mark.parametrize("columns", [40, 60])
@pytest.mark.parametrize("words", VIEWS)
def test_no_line_is_wider_than_the_terminal(bench: ServedBench, words: str, columns: int) -> None:
    """Only what is to be copied may be: a path behind its name, and a command."""
    places = {
        "STATE": str(bench.folder / "kept"),
        "PORT": bench.ports["s1"],
        "RECORDING": str(bench.recording_file),
    }
    shown = in_terminal(bench, [places.get(word, word) for word in words.split()], columns)
    assert len(shown) > 1
    assert [each for each in shown if len(each) > columns and not is_whole(each)] == []


def is_whole(text: str) -> bool:
    """True if a line is one word, with a name before it, a command, a remark, which may be searched for, or a
    bar that is drawn again and again."""
    return len(text.split()) <= 2 or text.startswith((" hil ", "hil: ")) or BAR in text


def in_terminal(bench: ServedBench, words: list[str], columns: int) -> list[str]:
    """Lines that a command prints in a terminal of so many columns, without their styles."""
    ours, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    given = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    command = [sys.executable, "-P", "-c", HIL, *words]
    if words[0] not in ELSEWHERE:
        command += ["--runtime-dir", str(bench.folder / "run")]
    process = subprocess.Popen(command, stdout=terminal, stderr=terminal, stdin=terminal, env=given)
    os.close(terminal)
    printed = b""
    with suppress(OSError):  # its end
        while part := os.read(ours, 4096):
            printed += part
    os.close(ours)
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", printed.decode())
    assert process.wait() == 0 or words[0] in MAY_FAIL, text
    return [each.rstrip() for each in text.splitlines()]
