"""Pages in the terminal: groups, headings, search, and what a narrow screen shows."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from hil.cli.documents.page_text import GROUPS, beginning_at, group_of, headings
from hil.cli.documents.shown_page import rendered
from hil.cli.framework.command_group import app
from hil.cli.framework.installed_files import find_pages

PAGE = """# Title

Text with a [link](runs.md#a) and ![a picture](x.png).

```sh
# no heading
```

## One `two`

| long | cells |
|---|---|
| `rate(hil_missed_ticks_total[5m])_and_more_of_it` | a<br>b |

## Twice

## Twice
"""


def hil(*words: str) -> Any:
    return CliRunner().invoke(app, words)


def test_no_group_hides_a_page() -> None:
    assert not set(GROUPS) & set(find_pages())
    assert hil("docs", "reference").output.startswith("# Reference\n")


def test_pages_are_listed_in_their_groups() -> None:
    listed = hil("docs").output
    places = [listed.index(f" {group}:") for group in GROUPS]
    assert places == sorted(places)
    assert "`hil docs decisions` lists them" in listed
    assert "0003-input-log" not in listed
    assert "0003-input-log" in hil("docs", "decisions").output
    assert {group_of(page) for page in find_pages().values()} == {*GROUPS}


def test_headings_are_those_of_links() -> None:
    anchors = [each.anchor for each in headings(PAGE)]
    assert anchors == ["title", "one-two", "twice", "twice-1"]
    assert (beginning_at(PAGE, "one-two") or "").startswith("## One `two`\n")
    assert (beginning_at(PAGE, "One two") or "").startswith("## One `two`\n")
    assert beginning_at(PAGE, "no-heading") is None


def test_a_page_begins_at_a_heading() -> None:
    text = find_pages()["health"].file.read_text()
    assert hil("docs", "docs/how-to/health.md#metrics").output == text[text.index("## Metrics") :]
    wrong = hil("docs", "health#metrix")
    assert wrong.exit_code == 2
    assert 'did you mean "metrics"?' in wrong.output


def test_a_page_that_was_renamed_is_found_by_its_old_name() -> None:
    old = hil("docs", "mother#commands")
    assert (old.exit_code, old.stderr) == (0, "hil: the page `mother` is now `line`\n")
    assert old.stdout == hil("docs", "line#commands").stdout
    assert "mother" not in json.loads(hil("docs", "--json").output)


def test_a_word_that_is_no_page_is_searched() -> None:
    found = json.loads(hil("docs", "metrics", "--json").output)["found"]
    assert {"page": "health#metrics", "text": "Metrics"} in found
    by_text = json.loads(hil("docs", "SCHED_FIFO", "--json").output)["found"]
    assert "real-time" in [row["page"] for row in by_text]
    wrong = hil("docs", "qwertyuiop")
    assert (wrong.exit_code, "none has this word" in wrong.output) == (2, True)


@pytest.mark.parametrize("columns", [40, 60, 80])
def test_a_page_fits_its_terminal_and_is_whole(columns: int) -> None:
    shown = rendered(PAGE, columns, colours=False)
    assert max(map(len, shown.splitlines())) <= columns
    assert "(picture: a picture)" in shown
    assert "(runs.md#a)" in shown
    assert "…" not in shown
    assert "a; b" in shown


def test_a_table_of_many_columns_has_its_words_whole() -> None:
    names = ("operation", "parameters", "the role of its user", "outcome", "example of a request")
    page = (
        f"# T\n\n| {' | '.join(names)} |\n{'|---' * 5}|\n| commands | `interval_ms` | viewer | a | list |\n"
    )
    shown = rendered(page, 60, colours=False)
    assert "parameters: interval_ms\n" in re.sub(" +\n", "\n", shown)
    assert all(f"{name}: " in shown for name in names)
    assert "operation: " not in rendered(page, 120, colours=False)


def test_a_page_is_no_command_to_the_terminal() -> None:
    assert "\x1b]" not in rendered("# T\n\na\x1b]0;x\x07b", 60, colours=True)


def test_json_has_the_file() -> None:
    answer = json.loads(hil("docs", "runs", "--json").output)
    assert Path(answer["file"]).read_text() == answer["text"]
