"""The sketchbooks of the IDEs of a user, and what is installed into each."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from hil.arduino import sketchbooks
from hil.arduino.sketchbooks import find_sketchbooks
from hil.cli.framework.command_group import app

HARDWARE = "hardware/hil/virtual"


class Home:
    """A home with settings of IDEs; no IDE of this computer is seen from it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.env = {"PATH": str(path / "bin"), "HOME": str(path)}

    def write(self, name: str, text: str) -> Path:
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def folder(self, name: str) -> Path:
        path = self.path / name
        path.mkdir(parents=True, exist_ok=True)
        return path

    def found(self, option: Path | None = None, **env: str) -> list[Path]:
        return find_sketchbooks(option, self.env | env, self.path)

    def run(self, *words: str, code: int = 0) -> str:
        done = CliRunner().invoke(app, ["arduino", *words])
        assert done.exit_code == code, done.output
        return done.output

    def tree(self) -> set[str]:
        return {str(path.relative_to(self.path)) for path in self.path.rglob("*")}


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Home:
    made = Home(tmp_path)
    for name, value in made.env.items():
        monkeypatch.setenv(name, value)
    monkeypatch.delenv("ARDUINO_DIRECTORIES_USER", raising=False)
    monkeypatch.setattr(sketchbooks, "_PLACES", (tmp_path / "opt",))
    monkeypatch.setattr(sketchbooks, "_DEBIANS_IDE", tmp_path / "usr/share/arduino")
    return made


def test_without_settings_it_is_the_default_of_all_ides(home: Home) -> None:
    assert home.found() == [home.path / "Arduino"]
    assert home.found(Path("/typed"), ARDUINO_DIRECTORIES_USER="/env") == [Path("/typed")]


def test_the_ide_2_and_arduino_cli(home: Home) -> None:
    mine = home.folder("mine")
    home.write(".arduino15/arduino-cli.yaml", f"directories:\n  user: {mine}\n")
    assert home.found() == [mine]
    for useless in ("", "directories:", "directories: [user]", "a: b: c", "board_manager: {}"):
        home.write(".arduinoIDE/arduino-cli.yaml", useless)
        assert home.found() == [mine]
    home.write(".arduinoIDE/arduino-cli.yaml", f"directories:\n  user: {home.path / 'gone'}\n")
    assert home.found() == [mine]
    home.write(".arduinoIDE/arduino-cli.yaml", f"directories:\n  user: {home.folder('ide')}\n")
    assert home.found() == [home.path / "ide", mine]
    assert home.found(ARDUINO_DIRECTORIES_USER="/env") == [Path("/env")]


def test_the_ide_1_8(home: Home) -> None:
    book = home.folder("sketches and more")
    preferences = home.write(
        ".arduino15/preferences.txt", f"board=uno\n#x\nsketchbook.path = {book} \nlast=1\n"
    )
    assert home.found() == [book]
    home.write(".arduinoIDE/arduino-cli.yaml", f"directories:\n  user: {home.folder('ide')}\n")
    assert home.found() == [home.path / "ide", book]
    assert home.found(ARDUINO_DIRECTORIES_USER="/env") == [Path("/env"), book]  # it does not read that one
    home.write(".arduinoIDE/arduino-cli.yaml", f"directories:\n  user: {book}\n")
    assert home.found() == [book]
    for useless in ("sketchbook.path=", "sketchbook.path", "sketchbook.pathology=/tmp", "\0"):
        preferences.write_text(useless)
        assert home.found() == [book]
    preferences.write_bytes(b"sketchbook.path=\xff\n")
    assert home.found() == [book]


@pytest.mark.parametrize(
    "place", ["opt/arduino-1.8.19", "arduino-1.8.13", "usr/share/arduino", "on the path"]
)
def test_a_portable_ide(home: Home, place: str) -> None:
    ide = home.folder(place)
    if place == "on the path":
        home.write(f"{place}/arduino", "#!/bin/sh\n").chmod(0o755)
        (home.folder("bin") / "arduino").symlink_to(ide / "arduino")
    home.folder(f"{place}/portable")
    assert home.found() == [home.path / "Arduino"]
    inside = home.folder(f"{place}/portable/sketchbook")
    assert home.found() == [inside]
    preferences = home.write(f"{place}/portable/preferences.txt", "sketchbook.path=sketchbook\n")
    assert home.found() == [inside]
    preferences.write_text(f"sketchbook.path={home.folder('elsewhere')}\n")
    assert home.found() == [home.path / "elsewhere"]


def test_install_into_each_and_uninstall(home: Home) -> None:
    books = [home.folder("ide"), home.folder("old")]
    home.write(".arduinoIDE/arduino-cli.yaml", f"directories:\n  user: {books[0]}\n")
    home.write(".arduino15/preferences.txt", f"sketchbook.path={books[1]}\n")
    before = home.tree()
    said = home.run("install")
    assert all(
        f"wrote {book / HARDWARE / name}" in said for book in books for name in ("platform.txt", "boards.txt")
    )
    assert f"Nothing to do in {books[0]} and {books[1]}." in home.run("install")
    changed = books[0] / HARDWARE / "boards.txt"
    text = changed.read_text()
    changed.write_text(text + "x=1\n")
    said = home.run("uninstall", code=1)  # what somebody has changed stays, and keeps no other from going
    assert str(changed) in said
    assert (books[0] / HARDWARE / "platform.txt").exists()
    assert list(books[1].iterdir()) == []
    changed.write_text(text)
    home.run("uninstall")
    assert home.tree() == before


def test_of_a_home_without_an_ide_nothing_is_left(home: Home) -> None:
    home.run("install")
    assert (home.path / "Arduino" / HARDWARE / "platform.txt").exists()
    home.write(
        ".arduinoIDE/arduino-cli.yaml", f"directories:\n  user: {home.folder('new')}\n"
    )  # an IDE comes
    before = home.tree()
    assert "removed" in home.run("uninstall")
    assert home.tree() == {name for name in before if not name.startswith("Arduino")}


def test_the_default_stays_with_what_others_have_there(home: Home) -> None:
    sketch = home.write("Arduino/blink/blink.ino", "")
    home.run("install")
    home.run("uninstall")
    assert home.tree() == {"Arduino", "Arduino/blink", str(sketch.relative_to(home.path))}
