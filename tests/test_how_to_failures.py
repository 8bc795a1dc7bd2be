"""The report of a test that fails, as ``docs/how-to/write-a-test.md`` shows it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_blocks import blocks

PAGE = "docs/how-to/write-a-test.md"
HEADING = "test_jammed.py"


@pytest.mark.thorough
@pytest.mark.long
def test_the_pages_test_fails_and_says_what_the_page_shows(tmp_path: Path) -> None:
    text = {each.language: each.text for each in blocks(PAGE) if each.heading == HEADING}
    (tmp_path / HEADING).write_text(text["python"])
    env = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    plugins = ("-p", "hil.testing.plugin", "-p", "no:cacheprovider")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, "--hil-artifacts", "kept", HEADING]
    env["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    done = subprocess.run(command, env=env, capture_output=True, text=True, cwd=tmp_path, check=False)
    said = re.sub(r"^-+ (.*?) -+$", r"--- \1 ---", done.stdout, flags=re.M)
    assert text["text"] in said
    (folder,) = (tmp_path / "kept").iterdir()
    names = {path.name for path in folder.iterdir()}
    assert names == {"failure.html", "inputs.jsonl", "traffic.pcapng", "m1.svg"}
    page = Path(__file__).parents[1].joinpath(PAGE).read_text()
    assert [name for name in names if f"`{name}`" not in page] == []
