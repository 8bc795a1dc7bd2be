"""Configuration and program of ``docs/how-to/can-channels.md``."""

import re
import subprocess
import sys

from e2e_support import PATIENCE_S, Place
from markdown_blocks import blocks

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
