"""Lines and tables of commands: the text without a terminal is that which rich makes."""

import io

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
