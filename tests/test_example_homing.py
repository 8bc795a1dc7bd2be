"""``examples/homing``: its tests in memory, at a daemon, and at the slide, here a second daemon."""

import os
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml
from e2e_support import PATIENCE_S

from hil.testing import LiveError, NotInTime, live

EXAMPLE = Path(__file__).parents[1] / "examples" / "homing"
README = (EXAMPLE / "README.md").read_text()
SWITCH_DEG = -180
MARKED = re.compile(r"^( *)```python\n(.*?)^ *```", re.M | re.S)
KNOWN_AS = {"pytest": "pytest", "robot": "robot slide.robot"}
"""Commands of the README by the program that a job runs."""
Run = Callable[..., str]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Run a test's command in a copy of the example; answers what it said."""
    folder = tmp_path / "homing"
    shutil.copytree(EXAMPLE, folder)
    paths = {"XDG_RUNTIME_DIR": str(tmp_path / "run"), "XDG_STATE_HOME": str(tmp_path / "state")}

    def in_copy(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", *words],
            cwd=folder,
            env=os.environ | paths,
            capture_output=True,
            text=True,
            timeout=6 * PATIENCE_S,
            check=False,
        )
        return done.stdout + done.stderr

    return in_copy


@pytest.fixture
def slide(tmp_path: Path) -> Iterator[Path]:
    """Slide with a switch at its end: a SAC behind a pty. Answers the file that says where it is."""
    file = tmp_path / "slide.yaml"
    with live({"bench": "desk", "devices": {"s1": {"profile": "sac"}}}, capture=False) as desk:
        file.write_text((EXAMPLE / "slide.yaml").read_text().replace("/dev/ttyUSB0", desk.ports["s1"]))
        is_over = threading.Event()

        def be_the_switch() -> None:
            sac, axis = desk.device("s1"), desk.axis("s1")
            while not is_over.is_set():
                try:
                    desk.wait_until("s1", f"speed_rpm > 0 and position_deg <= {SWITCH_DEG}", within_ms=200)
                    sac.pin("Estop", 0)
                    desk.wait_until("s1", "speed_rpm == 0")
                    axis.zero()  # the next test comes to the switch, too
                    sac.pin("Estop", 1)
                except (NotInTime, LiveError):
                    continue

        switch = threading.Thread(target=be_the_switch)
        switch.start()
        yield file
        is_over.set()
        switch.join()


def told(command: str) -> str:
    """Result that the README has for a command."""
    (line,) = re.findall(rf"^\$ {re.escape(command)} *(?:#.*)?\n(?:\.\.\.\n)?(.*)$", README, re.M)
    assert isinstance(line, str)
    return line


@pytest.mark.thorough
def test_in_memory_and_with_the_test_of_a_new_failure(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "homing" / "test_home.py"
    assert told("pytest") in run("pytest", "-q", "-p", "no:cacheprovider")
    (indent, text) = MARKED.findall(README)[0]
    file.write_text(file.read_text() + "\n\n" + re.sub(f"^{indent}", "", text, flags=re.M))
    assert "1 passed" in run("pytest", "-q", "-k", "power")


@pytest.mark.thorough
@pytest.mark.long
def test_at_the_slide(run: Run, slide: Path) -> None:
    said = run("pytest", "-q", "-p", "no:cacheprovider", f"--hil={slide}")
    assert "3 passed, 1 skipped" in said, said
    assert f"hil: 1 test skipped at --hil={slide}:\n  1: kind=real: s1 is real, and hil cannot" in said


@pytest.mark.thorough
@pytest.mark.long
def test_the_suite_of_robot_framework_at_the_slide(run: Run, slide: Path) -> None:
    pytest.importorskip("robot", reason="Robot Framework is not installed")
    said = run("robot", "--variable", "KIND:real", "--variable", f"BENCH:{slide}", "slide.robot")
    assert "4 tests, 2 passed, 0 failed, 2 skipped" in said, said


@pytest.mark.thorough
@pytest.mark.parametrize("job", ["virtual", "night", pytest.param("live", marks=pytest.mark.long)])
def test_its_ci(run: Run, job: str) -> None:
    pytest.importorskip("robot", reason="Robot Framework is not installed")
    steps = yaml.safe_load((EXAMPLE / ".github/workflows/test.yml").read_text())["jobs"][job]["steps"]
    install, *lines = [step["run"] for step in steps if "run" in step]
    assert install.startswith("pip install ")
    for line in lines:
        said = run(*line.replace("1000", "3").split())
        assert (told(KNOWN_AS[line.split()[0]]) if job != "night" else "12 passed") in said, said
