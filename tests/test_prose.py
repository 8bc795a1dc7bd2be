"""``check_prose.py``: what it reads in pages and Python files, what it finds there, and what may stand."""

import pytest

from check_prose import RULES, Prose, findings, page_prose, python_prose, read_rules, report

OWN = """
off = ["typography"]
longest_sentence_words = 12
[terms]
"stays? away" = "a time-out"
[[exceptions]]
rule = "weasel_words"
text = "very large"
file = "docs/bounds.md"
reason = "a class of the standard"
"""


def found(file: str, text: str) -> list[str]:
    """Lines that the checker prints about a file."""
    rules = read_rules(OWN)
    lines = report(findings(Prose({file: text}), rules), rules.exceptions)
    return [line for line in lines if "nothing needs" not in line]


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("# A page\n\nIf a set-point stays away, it stops.\n", "3:16: term"),
        ("If set-points stay\naway, it stops.\n", "1:15: term"),
        ("It is very big.\n", "1:7: weasel_words.very"),
        ("It is is big.\n", "1:4: lexical_illusions"),
        ('"It is very big," she said.\n', "1:8: weasel_words.very"),
        (
            "Short.\n\nOne two three four five six\nseven eight nine ten eleven twelve thirteen.\n",
            "3:1: long",
        ),
    ],
    ids=["term", "over two lines", "proselint", "word twice", "in quotes", "long sentence"],
)
def test_prose_of_a_page_is_read(text: str, where: str) -> None:
    (line,) = found("docs/page.md", text)
    assert line.startswith(f"docs/page.md:{where}")


@pytest.mark.parametrize(
    "text",
    [
        "```text\nIt stays away.\n```\n",
        "The key `stays away` is code.\n",
        "See [the page](stay%20away.md#stay-away).\n",
        "<!-- very -->\n",
        "| one two three four five six | seven eight nine ten eleven twelve thirteen |\n",
        "One two three four five six seven:\n\n- eight nine ten\n- eleven twelve thirteen\n",
    ],
    ids=["block", "inline", "link", "comment", "cells", "items"],
)
def test_code_in_a_page_is_left_out(text: str) -> None:
    assert found("docs/page.md", text) == []


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ('"""Module, very big."""\n', "1:12: weasel_words.very"),
        ('def f():\n    """A ö; it stays away."""\n', "2:16: term"),
        ('X = 1\n"""Number that stays\naway."""\n', "2:16: term"),
        ('raise ValueError(f"{x} stays away")\n', "1:24: term"),
        ('HELP = ("what stays "\n        "away")\n', "1:15: term"),
    ],
    ids=["module", "function", "attribute", "message", "in pieces"],
)
def test_docstrings_and_texts_of_a_program_are_read(text: str, where: str) -> None:
    (line,) = found("hil/program.py", text)
    assert line.startswith(f"hil/program.py:{where}")


@pytest.mark.parametrize(
    "text",
    [
        "stays = away = very = 1  # it stays away\n",
        'KEY = "very"\n',
        'X = "the ``very big``"\n',
        '"""It ends."""\nY = ends\n',
        'X = ("one two three four five six",\n     "seven eight nine ten eleven twelve thirteen")\n',
    ],
    ids=["names and comments", "one word", "code", "words on both sides of an end", "two texts"],
)
def test_code_of_a_program_is_left_out(text: str) -> None:
    assert found("hil/program.py", text) == []


def test_places_stay_what_they_are() -> None:
    page, program = "a `b` c\n\n```\nx\n```\nd\n", 'x = "one two"\n\n\ny = """three\nfour"""\n'
    for prose, text in ((page_prose(page), page), (python_prose(program), program)):
        assert [len(line) for line in prose.split("\n")] == [len(line) for line in text.split("\n")]


def test_an_exception_holds_in_its_file_for_its_text() -> None:
    assert found("docs/bounds.md", "A very large one.\n") == []
    assert len(found("docs/bounds.md", "A very small one.\n")) == 1
    assert len(found("docs/page.md", "A very large one.\n")) == 1


def test_an_exception_that_nothing_needs_is_told() -> None:
    rules = read_rules(OWN)
    (line,) = report(findings(Prose({"docs/bounds.md": "Nothing.\n"}), rules), rules.exceptions)
    assert line.startswith("prose.toml: nothing needs")


def test_each_exception_has_a_reason() -> None:
    assert all(exception.reason for exception in read_rules(RULES.read_text()).exceptions)
    with pytest.raises(KeyError, match="reason"):
        read_rules(OWN.replace("reason", "because"))
