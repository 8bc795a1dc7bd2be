"""Lines and tables of commands: the text without a terminal is that which rich makes."""

import io
import re

import pytest

from hil.cli.framework.consoles import ShownConsole
from hil.cli.framework.shown_view import Grid, Line, ShownView, is_terminal, line

CELLS = ("", "m1", "a name that is long", "two\nlines", "\u6f22\u5b57", "t\tab", "bell\a")


def by_rich(view: ShownView) -> str:
    console = ShownConsole(soft_wrap=True, markup=False, width=10_000)
    console.file = io.StringIO()
    console.print(view)
    return console.file.getvalue()


@pytest.mark.parametrize("gap", [1, 2])
@pytest.mark.parametrize("texts", [(), ("one",), ("one", "two\nhigh", "last")])
def test_tables(gap: int, texts: tuple[str, ...]) -> None:
    rows = [(a, b, "end") for a in CELLS for b in CELLS]
    for some in ([], rows[:1], rows):
        view = ShownView(Grid(("one", "two\nhigh", "last"), texts, some, gap=gap))
        assert f"{view}\n" == by_rich(view)


def test_lines() -> None:
    view = ShownView(
        Line([("one ", "bold"), ("two\nthree", "")]), line(""), line("\u6f22\rx\x1b", "red"), line("a\tb")
    )
    assert f"{view}\n" == by_rich(view)


def test_where_is_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    assert is_terminal() == ShownConsole().is_terminal
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert is_terminal()
    assert ShownConsole().is_terminal


LONG = ("spindle_of_the_left_corner", "/run/user/1000/hil/lab/spindle_of_the_left_corner")


def narrow(view: ShownView, columns: int, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", str(columns))
    shown = view.text().splitlines()
    plain = re.sub(r"\x1b\[[\d;]*m", "", by_rich(view))
    assert [each.rstrip() for each in plain.splitlines()] == [each.rstrip() for each in shown]
    return shown


@pytest.mark.parametrize("columns", [40, 60])
def test_a_table_that_is_too_wide_keeps_names_whole(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [("m1", "7", LONG[1], "ok"), (LONG[0], "12", LONG[1], "")]
    grid = Grid(("device", "count", "address", "state"), ("device", "address", "state"), rows)
    shown = narrow(ShownView(grid), columns, monkeypatch)
    assert shown[0].split() == ["device", "count"]
    assert [each for each in shown if len(each.rstrip()) > columns and LONG[1] not in each] == []
    assert sum(LONG[1] in each for each in shown) == 2
    assert sum(each.rstrip().endswith("state: ok") for each in shown) == 1
    ends = {len(each.rstrip()) for each in shown if each.rstrip().endswith(("count", " 7", " 12"))}
    assert len(ends) == 1, "numbers stand below each other"


def test_what_goes_below_first(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("device", "bytes in", "bytes out", "angle", "state of it all", "mode")
    grid = Grid(names, ("device",), [("m1", "1", "2", "3", "4", "5")], later=("bytes in", "bytes out"))
    shown = narrow(ShownView(grid), 40, monkeypatch)
    assert shown[0].split("  ") != names
    assert shown[2].strip().startswith("bytes in: 1")
    assert "angle" in shown[0]


def test_prose_is_wrapped_in_its_column(monkeypatch: pytest.MonkeyPatch) -> None:
    said = "a sentence that is much too long for a narrow terminal, and is wrapped there"
    grid = Grid(("kind", "about"), ("kind", "about"), [("byte_flip", said)], prose=("about",))
    shown = narrow(ShownView(grid, line(said, wraps=True)), 60, monkeypatch)
    assert max(map(len, shown)) <= 60
    assert " ".join(" ".join(shown).split()) == f"kind about byte_flip {said} {said}"


def test_where_no_terminal_is_a_table_is_as_wide_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("COLUMNS", "40")
    view = ShownView(Grid(("a", "b"), ("a",), [("x" * 30, "y" * 30)], prose=("a",)))
    assert view.text() == str(view)
    assert len(view.text().splitlines()) == 2
