"""Configuration, program and words of ``docs/how-to/can-channels.md``."""

import re
import subprocess
import sys

from e2e_support import PATIENCE_S, Place
from markdown_blocks import blocks

from hil.wire.can.frame_text import parse_frame
from hil.wire.canopen.canopen_words import CanOpenWords

PAGE = "docs/how-to/can-channels.md"


def first(language: str) -> str:
    return next(block.text for block in blocks(PAGE) if block.language == language)


def test_the_program_asks_the_drive() -> None:
    with Place() as place:
        place.serve(first("yaml")).started()
        done = subprocess.run(
            [sys.executable, "-c", first("python")], capture_output=True, text=True, timeout=PATIENCE_S
        )
    assert re.fullmatch(r"vendor [0-9a-f]{8}\n", done.stdout), done.stderr


def test_the_words_are_those_that_are_said() -> None:
    (text,) = (block.text for block in blocks(PAGE) if "hil decode" in block.text)
    rows = re.findall(r"can0 (\S+) +(\S.*?) \(\S+\)$", text, re.M)
    words = CanOpenWords()
    assert [words.say(parse_frame(frame)) for frame, _ in rows] == [said for _, said in rows]
    assert len(rows) == 4
