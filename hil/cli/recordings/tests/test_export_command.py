"""``hil export`` on the command line: what it writes, and what it says of bad input."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from hil.cli.framework.command_group import app
from hil.testing import Bench

CONFIG = {
    "bench": "one",
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
}
WITH_VCD = pytest.mark.skipif(
    subprocess.run([sys.executable, "-c", "import vcd"], capture_output=True).returncode != 0,
    reason="pyvcd is not installed: make .venv/.dev",
)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("logs") / "bench.log"
    with Bench(CONFIG) as bench, file.open("w") as opened:
        bench.start()
        bench.run(0.5)
        for text in (b"y", b"x", b"r\r90\r"):
            bench.port("m1").write(text)
            bench.run(400)
        bench.port("s1").write(b"m5v60\r")
        bench.run(1000)
        bench.inputs.write_to(opened)
    return file


def export(*words: object) -> Result:
    return CliRunner().invoke(app, ["export", *map(str, words)])


def refused(*words: object) -> str:
    done = export(*words)
    assert done.exit_code == 2, done.output
    assert not done.stdout
    return done.stderr.removeprefix("hil: ").strip()


def test_a_table(log: Path, tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    done = export(log, "m1.r", "s1", "-o", file, "--from", "5s", "--to", "5.1s", "--rate", "50")
    assert done.stdout == (
        f"wrote {file}: 6 rows of m1.r, s1.speed_rpm, s1.commanded_deg, s1.position_deg, 5s to 5.1s\n"
    )
    header, first, *rest = file.read_text().splitlines()
    assert header == "at_s,m1.r [deg],s1.speed_rpm,s1.commanded_deg,s1.position_deg"
    assert first.startswith("5.000000000,90,")
    assert [line.split(",")[0] for line in rest] == [
        f"5.{at}0000000" for at in ("02", "04", "06", "08", "10")
    ]


def test_a_pipe_and_json(log: Path, tmp_path: Path) -> None:
    done = export(log, "m1.r", "--format", "csv", "-o", "-", "--to", "20ms")
    assert done.stdout.splitlines() == ["at_s,m1.r [deg]", *(f"0.0{at}0000000,0" for at in range(3))]
    file = tmp_path / "a.pcapng"
    answer = json.loads(export(log, "s1", "-o", file, "--json").stdout)
    assert answer["file"] == str(file)
    assert answer["records"] > 3
    assert file.read_bytes().startswith(b"\x0a\x0d\x0d\x0a")


def test_drawings(log: Path, tmp_path: Path) -> None:
    drawn = export(log, "m1.r", "s1.position_deg", "--from", "3s")
    assert drawn.exit_code == 0
    assert "m1 r [deg]" in drawn.stdout
    assert "s1 position_deg [deg]" in drawn.stdout
    file = tmp_path / "a.svg"
    assert export(log, "m1", "s1", "-o", file, "--from", "-1s").exit_code == 0
    assert "<svg" in file.read_text()


@WITH_VCD
def test_pins_and_lines(log: Path, tmp_path: Path) -> None:
    file = tmp_path / "a.vcd"
    done = export(log, "-o", file)
    assert "ports on USB (m1) have no line and are left out; --usb-baud draws them" in done.stderr
    text = file.read_text()
    assert "$timescale 1 ns $end" in text
    assert " s1.clk $end" in text
    assert " m1.rx $end" not in text
    assert export(log, "m1", "-o", file, "--usb-baud", "9600").exit_code == 0
    assert " m1.rx $end" in file.read_text()
    assert "--usb-baud 115200 draws it" in refused(log, "m1.rx", "-o", file)
    assert 'did you mean "s1.clk"?' in refused(log, "s1.clc", "-o", file)


def test_names_and_windows_that_are_not_there(log: Path, tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    assert refused(log, "m1.yv", "-o", file).startswith("m1 has no field 'yv'; did you mean \"y")
    assert refused(log, "m2.r", "-o", file).startswith("'m2.r' names no axis: ")
    assert refused(log, "s1.net", "-o", tmp_path / "a.pcapng") == (
        "there is no port or wire 's1.net'; did you mean \"s1.network\"? there are m1, s1, s1.network"
    )
    assert "is not within the run, which is " in refused(log, "-o", file, "--from", "1h")
    assert (
        refused(log, "-o", file, "--from", "4s", "--to", "3s") == "--from 4s is behind --to 3s; exchange them"
    )
    assert refused(log, "-o", file, "--every", "soon") == (
        "--every: 'soon' is no time; write it as 10ms, 50us, 1s, or step"
    )
    assert "write 50us or more" in refused(log, "-o", file, "--every", "1us")
    assert refused(log, "-o", file, "--every", "1ms", "--rate", "5") == "choose one of --every and --rate"
    assert not [*tmp_path.iterdir()]


def test_formats_that_are_none(log: Path, tmp_path: Path) -> None:
    assert refused(log, "-o", "a.csw").startswith("a.csw: there is no format 'csw'; did you mean \"csv\"?")
    assert refused(log, "-o", "plain").startswith("plain: its name does not say in which format: ")
    assert refused(log, "-o", "-").startswith("add --format for the standard output: ")
    assert "there is no folder" in refused(log, "-o", tmp_path / "no" / "a.csv")
    assert "this is no recording; `hil recordings` lists" in refused(__file__, "-o", "a.csv")


def test_much_is_asked_for_again(log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hil.recorded.exports import export_size

    monkeypatch.setattr(export_size, "MOST_ROWS", 1000)
    file = tmp_path / "a.csv"
    assert refused(log, "m1.r", "-o", file, "--every", "1ms").endswith(
        "take less with --from, --to and --every, or add --yes"
    )
    assert not file.exists()
    assert export(log, "m1.r", "-o", file, "--every", "1ms", "--yes").exit_code == 0
    assert len(file.read_text().splitlines()) > 1000


def test_the_size_of_a_billion_rows() -> None:
    from hil.recorded.exports.export_formats import FORMATS
    from hil.recorded.exports.export_size import export_size
    from hil.recorded.recorded_fields import RunField

    fields = [RunField("m1", "r"), RunField("m2", "position_deg")]
    size = export_size(FORMATS["csv"], fields, 10**9 * 50_000, 50_000)
    assert size.is_large
    assert size.words() == "1,000,000,001 rows, about 42 GB"
    assert not export_size(FORMATS["csv"], fields, 3600 * 10**9, 10_000_000).is_large


def test_a_full_disk_leaves_nothing(log: Path, tmp_path: Path) -> None:
    """A file that may not grow further fails in the middle, as on a disk without room."""
    program = (
        "import resource, signal, sys\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))\n"
        "from hil.cli.entry import main\n"
        "sys.argv = ['hil', 'export', *sys.argv[1:]]\n"
        "main()\n"
    )
    file = tmp_path / "a.csv"
    file.write_text("as it was")
    # -B: a module that is compiled here would be cut off, too, and fail in each later start.
    words = [sys.executable, "-B", "-c", program, str(log), "-o", str(file), "--every", "1ms"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.startswith(f"hil: {file}: File too large")
    assert file.read_text() == "as it was"
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]
    full = export(log, "m1.r", "-o", "/dev/full", "--format", "csv")
    assert full.exit_code == 1
    assert full.stderr.startswith("hil: /dev/full: No space left on device; ")


def test_a_recording_that_grows(log: Path, tmp_path: Path) -> None:
    """Up to its last whole second, and it is said why."""
    lines = log.read_text().splitlines(keepends=True)
    cut, file = tmp_path / "cut.log", tmp_path / "a.csv"
    cut.write_text("".join(lines[:-1]) + lines[-1][:5])
    done = export(cut, "m1.r", "-o", file)
    assert done.exit_code == 0, done.output
    last_s = file.read_text().splitlines()[-1].split(",")[0]
    assert last_s.endswith(".000000000")
    assert int(last_s[:1]) >= 4
    assert f"hil: {cut}: its last lines are missing" in done.stderr
