"""``hil gcode``: files that are checked and planned, for people and for programs."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hil.cli.framework.command_group import app

EXAMPLES = Path(__file__).parents[3] / "examples" / "line"
MILL, DRAWING = str(EXAMPLES / "mill.yaml"), str(EXAMPLES / "drawing.ngc")


def gcode(*words: str, code: int = 0) -> tuple[str, str]:
    """Standard output and error of the command."""
    result = CliRunner().invoke(app, ["gcode", *words, "--dry-run"])
    assert result.exit_code == code, result.output
    return result.stdout, result.stderr


def written(folder: Path, text: str | bytes) -> str:
    file = folder / "made.ngc"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return str(file)


def test_the_example_has_its_figures() -> None:
    out, err = gcode(DRAWING, "--machine", MILL)
    assert out.replace(str(EXAMPLES) + "/", "") == (
        "drawing.ngc: 37 lines, 33 motions, no problems, 1 remark\n"
        "  way: 250.9 mm at a feed, 182.4 mm rapid; time: 25.5 s\n"
        "  range: X 0 to 88 mm, Y 0 to 40 mm, Z -1 to 3 mm\n"
        "  3 stretches in short segments, 8 lines with ramps\n"
        "  line: 38 commands a second at most, 116.9 can be at 38400 baud; each is 623 ms early at least\n"
    )
    assert "drawing.ngc:6:1: the machine has no switch for spindle" in err


def test_the_same_for_programs() -> None:
    out, _ = gcode(DRAWING, "--machine", MILL, "--json")
    figures = json.loads(out)
    assert figures["line"]["keeps_up"] is True
    assert figures["range"]["z"] == [-1.0, 3.0]
    assert figures["remarks"][0]["line"] == 6
    slow = json.loads(gcode(DRAWING, "--machine", MILL, "--json", "--feed", "50")[0])
    assert slow["duration_s"] > 1.3 * figures["duration_s"]


def test_every_problem_of_the_whole_file_with_a_caret(tmp_path: Path) -> None:
    file = written(tmp_path, "G21 F100\nG1 X500\n Y-3\nG1 A3\nM2\n")
    _, err = gcode(file, "--machine", MILL, code=2)
    said = [line for line in err.splitlines() if line.startswith(file)]
    assert [line.removeprefix(file) for line in said] == [
        ":2:1: X would go to 500 mm (write 0 to 120)",
        ":3:2: Y would go to -3 mm (write 0 to 80)",
        ":4:1: the machine has no axis A (leave A out, or add it to the machine)",
    ]
    assert "    3 |  Y-3\n      |  ^\n" in err


def test_a_line_that_cannot_keep_up_is_told_before_anything_moves(tmp_path: Path) -> None:
    dense = "\n".join(f"G1 X{n * 0.2:.2f} Y{n % 2 * 0.1:.1f} Z{n % 3 * 0.1:.1f}" for n in range(300))
    machine = tmp_path / "quick.yaml"
    machine.write_text(Path(MILL).read_text() + "segment_ms: 10\n")
    file = written(tmp_path, f"G21 F2400 G61\n{dense}\nM2\n")
    _, err = gcode(file, "--machine", str(machine), code=2)
    assert "the line cannot keep up: it needs 328 commands a second and can do 117 at 38400 baud" in err
    assert "Write segment_ms: 28 or more" in err
    gcode(file, "--machine", MILL)


@pytest.mark.parametrize(
    ("at", "said"),
    [("X7Q", "is no position"), ("A5", "the machine has no axis A"), ("7", "is no position")],
)
def test_where_the_machine_stands_has_to_be_said_well(at: str, said: str) -> None:
    assert said in gcode(DRAWING, "--machine", MILL, "--at", at, code=2)[1]


def test_a_position_is_where_the_path_begins(tmp_path: Path) -> None:
    file = written(tmp_path, "G21 G91 F600\nG1 X-5\nM2\n")
    gcode(file, "--machine", MILL, code=2)
    out, _ = gcode(file, "--machine", MILL, "--at", "X10.5 y 3")
    assert "X 5.5 to 10.5 mm, Y 3 to 3 mm" in out


def test_files_that_are_none(tmp_path: Path) -> None:
    assert "No such file" in gcode(str(tmp_path / "no.ngc"), "--machine", MILL, code=2)[1]
    assert "No such file" in gcode(DRAWING, "--machine", str(tmp_path / "no.yaml"), code=2)[1]
    assert "Is a directory" in gcode(str(tmp_path), "--machine", MILL, code=2)[1]
    latin = tmp_path / "latin.yaml"
    latin.write_bytes(b"machine: m\xfchle\n")
    assert "the byte 0xfc is not UTF-8 text" in gcode(DRAWING, "--machine", str(latin), code=2)[1]
    assert (
        "there is no axis"
        in gcode(DRAWING, "--machine", written(tmp_path, "machine: m\naxes: {}\n"), code=2)[1]
    )
