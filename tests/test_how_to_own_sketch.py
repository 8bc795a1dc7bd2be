"""``docs/how-to/own-sketch.md``: its job in CI, without what only a CI has."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from e2e_support import PATIENCE_S
from markdown_blocks import block, blocks
from sketch_preparations import need_toolchain, write_sketch

PAGE = "docs/how-to/own-sketch.md"
JOB = yaml.safe_load(block(PAGE, "In CI"))["jobs"]["sketch"]


@pytest.mark.thorough
@pytest.mark.parametrize("is_mended", [False, True])
def test_the_job_finds_the_fault(tmp_path: Path, *, is_mended: bool) -> None:
    need_toolchain()
    folder = tmp_path / "turns"
    write_sketch(PAGE, folder)
    install, install_hil, *lines = [step["run"] for step in JOB["steps"] if "run" in step]
    assert install.startswith("sudo apt-get install ")
    assert install_hil.startswith("pip install ")
    (mend,) = [each for each in blocks(PAGE) if "sed -i" in each.text]
    if is_mended:
        lines.insert(0, mend.text.splitlines()[0].removeprefix("$ "))
    done = subprocess.run(
        ["bash", "-e", "-c", "\n".join(lines)],
        cwd=folder,
        env=os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=3 * PATIENCE_S,
        check=False,
    )
    assert done.returncode == (0 if is_mended else 1), done.stdout + done.stderr
    assert ("1 passed" if is_mended else "done -25536") in done.stdout
    assert (folder / "failed").exists() != is_mended
