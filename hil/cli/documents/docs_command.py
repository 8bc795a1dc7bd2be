"""``hil docs``: the list of pages, a page, and pages that have a word."""

import sys
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hil.cli.documents.page_text import GROUPS, Heading, beginning_at, group_of, headings
from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.installed_files import Page, find_pages
from hil.cli.framework.shown_view import Grid, Line, ShownView, line

_MOST_HEADINGS = 4
"""Headings of a page that a search lists."""
_MOST_ROWS = 30
_NOW = {"mother": "line"}
"""Pages that have another name now, by the one before."""
_HINT = "`hil docs PAGE` shows one, `hil docs PAGE#HEADING` from a heading on, `hil docs WORD` searches."


def docs(
    topic: Annotated[
        str | None,
        typer.Argument(
            help="A page, as in runs; with a heading, as in runs#carry-it-out; a word to search; or a group"
            " of pages. [default: all pages]",
            show_default=False,
        ),
    ] = None,
    raw: Annotated[
        bool, typer.Option("--raw", help="Markdown, as where the output is no terminal.", show_default=False)
    ] = False,
) -> CommandAnswer:
    """Show a page of the documentation, search the pages, or list them.

    A page is shown in the pager of $PAGER, or less, if it is longer than the terminal.

    Example: hil docs runs
    """
    pages = find_pages()
    if not pages:
        raise fail("hil: this installation has no pages")
    if topic is None:
        return _listed(pages)
    if topic in GROUPS:
        return _listed({name: page for name, page in pages.items() if group_of(page) == topic}, whole=True)
    name, _, heading = topic.rpartition("/")[2].partition("#")
    name = name.removesuffix(".md")
    if name in _NOW:
        typer.echo(f"hil: the page `{name}` is now `{_NOW[name]}`", err=True)
        name = _NOW[name]
    if name not in pages:
        return _searched(topic, pages)
    text = pages[name].file.read_text()
    if heading:
        text = _from_heading(name, heading, text)
    answer = {"topic": name, "file": str(pages[name].file), "text": text}
    if raw or wants_json() or not sys.stdout.isatty():
        return CommandAnswer(answer, text.rstrip("\n"))
    from hil.cli.documents.shown_page import show_page

    show_page(text)
    return CommandAnswer(answer)


def _listed(pages: dict[str, Page], whole: bool = False) -> CommandAnswer:
    """List pages by group. ``whole``: decisions one by one, too."""
    width = max(map(len, (name for name, page in pages.items() if whole or group_of(page) != "decisions")))
    blocks = list[Line | Grid]()
    for group, about in GROUPS.items():
        inside = [(name, page.title) for name, page in pages.items() if group_of(page) == group]
        if not inside:
            continue
        head = (f"{group}:".ljust(width), about)
        if group == "decisions" and not whole:
            inside = [("", f"{len(inside)} pages; `hil docs decisions` lists them")]
        blocks += [Grid(head, head, inside, prose=(about,)), line("")]
    view = ShownView(*blocks, line(_HINT, wraps=True))
    return CommandAnswer({name: page.title for name, page in pages.items()}, view.text())


def _from_heading(name: str, wanted: str, text: str) -> str:
    if (found := beginning_at(text, wanted)) is not None:
        return found
    from hil.vocab.near_words import meant

    known = [each.anchor for each in headings(text)]
    there = f"its headings are {', '.join(known)}"
    raise fail(f"hil: page {name} has no heading {wanted!r}; {meant(wanted, known, there)}", 2)


def _searched(word: str, pages: dict[str, Page]) -> CommandAnswer:
    """List the pages that have a word in their name, their title or a heading; else those that have it in
    their text. Raises Exit with 2: none has."""
    from hil.vocab.near_words import did_you_mean, meant, nearest

    found = {name: places for name, page in pages.items() if (places := list(_places(word, name, page)))}
    if found:
        rows = [
            (f"{name}#{each.anchor}" if each.anchor else name, each.text)
            for name, places in found.items()
            for each in places[:_MOST_HEADINGS]
        ]
    else:
        counts = {name: page.file.read_text().lower().count(word.lower()) for name, page in pages.items()}
        ordered = sorted((name for name in counts if counts[name]), key=lambda name: -counts[name])
        rows = [(name, f"{pages[name].title} ({counts[name]} times)") for name in ordered] if word else []
    if not rows:
        near = meant(word, pages, "`hil docs` lists them")
        raise fail(f"hil: there is no page {word!r}, and none has this word; {near}", 2)
    columns = ("page", "heading" if found else "title")
    said = " ".join(filter(None, [f"there is no page {word!r};", did_you_mean(nearest(word, pages))]))
    said += f" pages that have it in their {'headings' if found else 'text'}:"
    more = [line(f"and {len(rows) - _MOST_ROWS} more")] if len(rows) > _MOST_ROWS else []
    table = Grid(columns, columns, rows[:_MOST_ROWS], prose=columns[1:])
    answer: dict[str, Any] = {"word": word, "found": [{"page": at, "text": text} for at, text in rows]}
    return CommandAnswer(answer, ShownView(line(said, wraps=True), table, *more).text())


def _places(word: str, name: str, page: Page) -> Iterator[Heading]:
    wanted = word.lower()
    if wanted in name or wanted in page.title.lower():
        yield Heading(page.title, "", 1)
    yield from (each for each in headings(page.file.read_text())[1:] if wanted in each.text.lower())
