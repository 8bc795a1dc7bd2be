"""The fault of ``docs/how-to/add-a-fault.md``, as it stands there, in a copy of hil."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from how_to_pages import run_tests, style_problems, write_files
from markdown_blocks import ROOT, blocks

PAGE = "add-a-fault"
NAME = f"docs/how-to/{PAGE}.md"
LEFT_OUT = shutil.ignore_patterns("tests", "native", "__pycache__", "*.pyx", "*.c")


@pytest.mark.thorough
def test_its_test_passes_with_its_changes_and_fails_without(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "hil", tmp_path / "hil", ignore=LEFT_OUT)
    (test,) = write_files(PAGE, tmp_path)
    assert style_problems([test]) == ""

    def run() -> str:
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        return run_tests(test, tmp_path, "--rootdir", str(tmp_path), environment=environment).stdout

    said = run()
    assert "1 failed" in said, said
    assert "kinds are byte_flip" in said, said
    changes = "".join(block.text for block in blocks(NAME) if block.language == "diff")
    subprocess.run(["git", "apply"], cwd=tmp_path, input=changes, text=True, timeout=60, check=True)
    said = run()
    assert "1 passed" in said, said
