"""The line under a problem, with a caret at the place."""

from pathlib import Path

import pytest

from hil.cli.framework.problem_lines import has_colours, with_lines


def test_the_line_and_a_caret_at_the_column(tmp_path: Path) -> None:
    file = tmp_path / "b.yaml"
    file.write_text("bench: t\n\tbäud: 3\n")
    said = f"{file}:2:8: too small (write 50 or more)"
    assert with_lines(f"hil: no\n{said}", {}, False).split("\n") == [
        "hil: no",
        said,
        "    2 |  bäud: 3",
        "      |        ^",
    ]


def test_a_file_that_cannot_be_read_again() -> None:
    assert with_lines("/dev/fd/9:1:3: x (y)", {"/dev/fd/9": "a: b"}, False).endswith("1 | a: b\n      |   ^")


@pytest.mark.parametrize("place", ["none.yaml:1:1", "b.yaml:3:1", "b.yaml:1:99", "b.yaml:0:0", "b.yaml:2:1"])
def test_a_place_that_is_not_there_is_said_without_a_line(place: str) -> None:
    assert with_lines(f"{place}: x (y)", {"b.yaml": "a: b\n\n"}, False) == f"{place}: x (y)"


def test_of_a_long_line_the_part_around_the_place() -> None:
    text = "x" * 500 + "!" + "y" * 500
    _, line, caret = with_lines("b.yaml:1:501: x (y)", {"b.yaml": text}, False).split("\n")
    assert len(line) < 120
    assert line[caret.index("^")] == "!"


def test_colours_are_for_terminals_that_want_them(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal:
        def isatty(self) -> bool:
            return True

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert has_colours(Terminal())  # type: ignore[arg-type]
    assert "\x1b[1;31m" in with_lines("b.yaml:1:1: x (y)", {"b.yaml": "a"}, True)
    monkeypatch.setenv("NO_COLOR", "1")
    assert not has_colours(Terminal())  # type: ignore[arg-type]
