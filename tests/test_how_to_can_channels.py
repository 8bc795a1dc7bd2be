"""Configuration, program and words of ``docs/how-to/can-channels.md``."""

import re
import subprocess
import sys
from pathlib import Path

from e2e_support import PATIENCE_S, Place
from how_to_pages import run_tests
from markdown_blocks import blocks

from hil.wire.can.frame_text import parse_frame
from hil.wire.canopen.canopen_words import CanOpenWords

PAGE = "docs/how-to/can-channels.md"


def first(language: str) -> str:
    return next(block.text for block in blocks(PAGE) if block.language == language)


def test_the_program_asks_the_drive() -> None:
    with Place() as place:
        place.serve(first("yaml"), bench="cell")
        done = subprocess.run(
            [sys.executable, "-c", first("python")], capture_output=True, text=True, timeout=PATIENCE_S
        )
    assert re.fullmatch(r"vendor [0-9a-f]{8}\n", done.stdout), done.stderr


def test_the_test_of_the_page_passes(tmp_path: Path) -> None:
    (text,) = (block.text for block in blocks(PAGE) if "def test_" in block.text)
    path = tmp_path / "test_page.py"
    path.write_text(text)
    done = run_tests(path, tmp_path)
    assert "1 passed" in done.stdout, done.stdout


def test_the_words_are_those_that_are_said() -> None:
    (text,) = (block.text for block in blocks(PAGE) if "hil decode" in block.text)
    rows = re.findall(r"can0 (\S+) +(\S.*?) \(\S+\)$", text, re.M)
    words = CanOpenWords()
    assert [words.say(parse_frame(frame)) for frame, _ in rows] == [said for _, said in rows]
    assert len(rows) == 4
