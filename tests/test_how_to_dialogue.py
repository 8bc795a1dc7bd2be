"""The lamp of docs/how-to/dialogue.md: its table, and the test of the page."""

import re
from pathlib import Path
from typing import Any

import pytest
from markdown_blocks import blocks

PAGE = "docs/how-to/dialogue.md"


def test_the_test_of_the_page_passes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for each in blocks(PAGE):
        if named := re.match(r"# (\S+\.yaml)\n", each.text):
            (tmp_path / named[1]).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / named[1]).write_text(each.text)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    text = next(each.text for each in blocks(PAGE) if each.heading == "test_lamp.py")
    exec(compile(text, PAGE, "exec"), names)
    names["test_the_lamp_is_bright_after_a_second"]()


def test_the_program_of_the_page_is_python() -> None:
    text = next(each.text for each in blocks(PAGE) if each.heading == "ask_lamp.py")
    compile(text, PAGE, "exec")
