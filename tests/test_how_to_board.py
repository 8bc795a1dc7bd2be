"""The board of docs/how-to/add-a-profile.md, which `hil profile new` begins, passes its tests."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from how_to_pages import run_tests
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.testing import Bench

PAGE = (Path(__file__).parents[1] / "docs/how-to/add-a-profile.md").read_text()
FILES = ("board.py", "firmware.py", "profile.yaml", "tests/test_pinger.py")


def block(heading: str) -> str:
    """Text of the first block below a heading."""
    (text,) = re.findall(rf"^## {re.escape(heading)}\n.*?^```\w+\n(.*?)^```$", PAGE, re.M | re.S)[:1]
    return str(text)


def said(*command: str, code: int = 0) -> list[str]:
    done = CliRunner().invoke(app, command)
    assert done.exit_code == code, done.output
    return done.output.splitlines()


def pass_tests(board: Path) -> None:
    """Run a board's tests as its author does."""
    done = run_tests(board, board.parents[1])
    assert done.returncode == 0, done.stdout


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_page_from_its_beginning_to_its_end(lab: Path) -> None:
    shown = re.findall(r"^```text\n(.*?)^```$", PAGE, re.M | re.S)
    new, *begun, check, passed = shown[0].splitlines()
    assert said(*new.split()[2:]) == begun
    assert said(*check.split()[2:]) == [passed]
    (bench,) = re.findall(r"^```yaml\n(bench: .*?)^```$", PAGE, re.M | re.S)
    (lab / "try.yaml").write_text(bench)
    assert said("check", "try.yaml") == ["try.yaml: bench try, 1 device, no problems"]
    for file in FILES:
        assert block(file) == (lab / "boards" / "pinger" / file).read_text(), f"the page's {file}"
    pass_tests(lab / "boards" / "pinger")
    board = lab / "boards" / "pinger" / "board.py"
    board.write_text(board.read_text().replace("import Pinger", "import Pingr"))
    _, *problems = shown[1].splitlines()

    assert [line.replace(f"{lab}/", "") for line in fresh("check", "try.yaml", code=2)] == problems


@pytest.mark.thorough
def test_the_board_with_the_pages_motor(lab: Path) -> None:
    said("profile", "new", "pinger", "--folder", "boards")
    yaml = lab / "boards" / "pinger" / "profile.yaml"
    (motor,) = re.findall(r"^```yaml\n(law: .*?)^```$", PAGE, re.M | re.S)
    yaml.write_text(yaml.read_text() + motor)
    pass_tests(lab / "boards" / "pinger")
    with Bench({"bench": "t", "profile_path": ["boards"], "devices": {"a1": {"profile": "pinger"}}}) as bench:
        assert bench.axis("a1").snapshot().position_deg == 90.0


def fresh(*command: str, code: int) -> list[str]:
    """Run a command in a process of its own: this one has the board already."""
    script = f"import sys; sys.argv = ['hil', *{command!r}]; from hil.cli.entry import main; main()"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == code, done.stderr
    return (done.stdout + done.stderr).splitlines()


@pytest.mark.thorough
def test_a_new_board_passes_its_tests_as_it_is(lab: Path) -> None:
    said("profile", "new", "laser_gate", "--folder", "my/boards")
    pass_tests(lab / "my" / "boards" / "laser_gate")
    assert "class LaserGate:" in (lab / "my/boards/laser_gate/firmware.py").read_text()


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("sac", "hil: there is a board sac already, that of hil, "),
        ("Pinger", "hil: 'Pinger' is not a name; write a letter a-z and up to 31 more of a-z, 0-9 and _"),
        ("laser-gate", "hil: 'laser-gate' is not a name"),
        ("there", "hil: there is there already; choose another name, or remove it"),
    ],
)
def test_a_name_that_does_not_do_is_refused(lab: Path, name: str, why: str) -> None:
    (lab / "there").mkdir()
    before = sorted(lab.rglob("*"))
    assert said("profile", "new", name, code=2)[0].startswith(why)
    assert sorted(lab.rglob("*")) == before


def test_the_list_has_all_boards_and_what_is_wrong_with_one(lab: Path) -> None:
    said("profile", "new", "pinger", "--folder", "boards")
    said("profile", "new", "spoilt", "--folder", "boards")
    (lab / "boards/spoilt/board.py").write_text("PROFILE = 1\n")
    listed = said("profile", "list", "--folder", "boards")
    assert [line for line in listed if line.startswith(("pinger", "spoilt"))] == [
        f"pinger: Board pinger ({lab}/boards/pinger)",
        f"spoilt: cannot be used ({lab}/boards/spoilt)",
    ]
    assert any(line.startswith("sac: SAC single-axis stepper controller") for line in listed)
    assert any("boards/spoilt/board.py:1:11: PROFILE is no Profile, but a int" in line for line in listed)
    (lab / "try.yaml").write_text("bench: t\nprofile_path: [boards]\ndevices: {a1: {profile: pinger}}\n")
    known = json.loads("\n".join(said("schema", "try.yaml")))["$defs"]["DeviceConfig"]["properties"]
    assert "pinger" in known["profile"]["enum"]
    *_, end = said("check", "try.yaml")
    assert end == "try.yaml: bench t, 1 device, no problems; not used and not usable: spoilt"
    assert said("profile", "check", "boards/spoilt", code=2)[0].startswith("hil: 1 problem in ")
    assert said("profile", "check", "boards/nowhere", code=2)[0].startswith(
        "hil: there is no folder boards/nowhere; "
    )
