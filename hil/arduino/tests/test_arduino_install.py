"""The hardware folder in a sketchbook: what is written, and that only that is removed."""

import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hil.arduino.install import (
    InstallError,
    boards_txt,
    install,
    platform_txt,
    uninstall,
)
from hil.arduino.protocol import PROTOCOL
from hil.cli.framework.command_group import app
from hil.compose import find_catalogue

FILES = ("platform.txt", "boards.txt")


def run(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, ["arduino", *arguments])
    assert done.exit_code == code, done.output
    return done.output


def properties(path: Path) -> dict[str, str]:
    """Properties of a file as the IDE reads it: comments out, each line split at its first equals sign."""
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return dict(line.split("=", 1) for line in lines)


def tree(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def test_install_again_and_uninstall(tmp_path: Path) -> None:
    book = ("--sketchbook", str(tmp_path))
    (tmp_path / "libraries").mkdir()
    said = run("install", *book)
    folder = tmp_path / "hardware/hil/virtual"
    assert all(f"wrote {folder / name}\n" in said for name in FILES)
    before = {name: (folder / name).stat().st_mtime_ns for name in FILES}
    assert "Nothing to do" in run("install", *book)
    assert {name: (folder / name).stat().st_mtime_ns for name in FILES} == before
    said = run("uninstall", *book)
    assert all(f"removed {folder / name}\n" in said for name in FILES)
    assert tree(tmp_path) == {"libraries"}
    assert "Nothing to do" in run("uninstall", *book)


def test_what_the_ide_reads(tmp_path: Path) -> None:
    run("install", "--sketchbook", str(tmp_path), "--runtime-dir", "/tmp/a b")
    platform = properties(tmp_path / "hardware/hil/virtual/platform.txt")
    assert set(platform) == {
        "name",
        "version",
        f"pluggable_discovery.{PROTOCOL}.pattern",
        f"discovery.{PROTOCOL}.pattern",
        f"pluggable_monitor.pattern.{PROTOCOL}",
    }
    assert platform["version"].replace(".", "").isdigit()
    program, *words = shlex.split(platform[f"pluggable_discovery.{PROTOCOL}.pattern"])
    assert words == ["arduino-discovery", "--runtime-dir", "/tmp/a b"]
    assert Path(program).is_absolute()
    of_1_8 = shlex.split(platform[f"discovery.{PROTOCOL}.pattern"])
    assert of_1_8 == [program, "arduino-discovery", "--ide-1.8", "--runtime-dir", "/tmp/a b"]
    assert shlex.split(platform[f"pluggable_monitor.pattern.{PROTOCOL}"]) == [program, "arduino-monitor"]
    boards = properties(tmp_path / "hardware/hil/virtual/boards.txt")
    assert boards["mechaduino.upload_port.0.profile"] == "mechaduino"
    assert boards["mechaduino.name"].startswith("Mechaduino ")


def test_an_old_version_is_replaced(tmp_path: Path) -> None:
    install(tmp_path, {"platform.txt": "version=0.0.1\n", "boards.txt": ""})
    new = {"platform.txt": "version=0.0.2\n", "boards.txt": ""}
    assert [path.name for path in install(tmp_path, new)] == ["platform.txt"]
    assert "version=0.0.2" in (tmp_path / "hardware/hil/virtual/platform.txt").read_text()


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("change", ["\nx=1\n", "\xff"])
def test_a_changed_file_is_nobodys_to_touch(tmp_path: Path, name: str, change: str) -> None:
    run("install", "--sketchbook", str(tmp_path))
    path = tmp_path / "hardware/hil/virtual" / name
    path.write_bytes(path.read_bytes() + change.encode("latin-1"))
    before = {each: each.read_bytes() for each in path.parent.iterdir()}
    for command in ("install", "uninstall"):
        assert str(path) in run(command, "--sketchbook", str(tmp_path), code=1)
    assert {each: each.read_bytes() for each in path.parent.iterdir()} == before


def test_what_others_put_beside_it_stays(tmp_path: Path) -> None:
    run("install", "--sketchbook", str(tmp_path))
    local = tmp_path / "hardware/hil/virtual/platform.local.txt"
    local.write_text("x=1\n")
    other = tmp_path / "hardware/other/avr"
    other.mkdir(parents=True)
    run("uninstall", "--sketchbook", str(tmp_path))
    assert {path.name for path in tmp_path.rglob("*.txt")} == {"platform.local.txt"}
    local.unlink()
    run("install", "--sketchbook", str(tmp_path))
    run("uninstall", "--sketchbook", str(tmp_path))
    assert tree(tmp_path) == {"hardware", "hardware/other", "hardware/other/avr"}


def test_a_sketchbook_that_cannot_be_used_is_said(tmp_path: Path) -> None:
    (tmp_path / "hardware").write_text("not a folder")
    assert "hil: " in run("install", "--sketchbook", str(tmp_path), code=1)


@pytest.mark.parametrize("path", ['/a"b/hil', "/a{b}/hil", "/a\\b/hil", "/a\nb/hil"])
def test_a_path_that_cannot_be_quoted_is_refused(path: str) -> None:
    with pytest.raises(InstallError, match="another folder"):
        platform_txt(Path(path), ())


def test_every_profile_is_a_board() -> None:
    profiles = find_catalogue().profiles
    text = boards_txt(profiles.values())
    assert {line.split(".")[0] for line in text.splitlines()} == set(profiles)


def test_uninstall_of_nothing(tmp_path: Path) -> None:
    assert uninstall(tmp_path, FILES) == []
    assert tree(tmp_path) == set()


def test_alone_it_explains() -> None:
    said = run()
    assert "hil arduino install" in said
    assert "hil:virtual:mechaduino" in said
