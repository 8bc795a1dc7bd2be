"""``docs/glossary.md`` against the code: one word for one thing."""

import ast
import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import pytest
from mentions import MENTION, is_defined

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "glossary.md"
ROOTS = sorted(init.parent.name for init in ROOT.glob("*/__init__.py"))
ENDINGS, VERBS, PLAIN = "Endings of class names", "Verbs", "Plain words"
NOUNS_MOST, VERBS_MOST, TAKES_MOST = 120, 25, 4
SINGULAR = {"axes": "axis"}
LONGEST = 160
"""Characters of a definition."""

TWICE = {
    "Axis": "an axis as its firmware, as runs and as the client for scripts see it",
    "Bench": "the faces of a bench in the client for scripts and in the test kit",
    "Options": "hil looks for it in each kind of port and bridge",
    "Desk": "the contract, and what carries it out",
    "RunAxis": "an axis of a run, and what a real board is to one",
    "Command": "a row in the table of a board's commands, a request in a bridge: none is seen outside",
    "Memory": "a device's, and how one board's firmware sees it",
    "Parameter": "what a verb takes, and a row of a board's own screen",
    "Progress": "how far a dialogue has come, and a run",
    "Refused": "a change of a bench that is not made, and a Modbus request that is not done",
    "Request": "what has come to a bridge, and what a Modbus client asks",
}
"""Names of classes that the product has twice, and why they may be."""


class Row(NamedTuple):
    """Row of a table: its words, what is said of them, and the last column."""

    section: str
    words: tuple[str, ...]
    definition: str
    where: str


def rows() -> list[Row]:
    found = []
    for part in re.split(r"^## ", PAGE.read_text(), flags=re.M)[1:]:
        for line in part.splitlines():
            if line.startswith("| **"):
                cells = [cell.strip() for cell in line.strip("|").split("|")]
                found.append(
                    Row(
                        part.splitlines()[0],
                        tuple(re.findall(r"\*\*([^*]+)\*\*", cells[0])),
                        cells[1],
                        cells[-1],
                    )
                )
    return found


def words(*, endings: bool) -> set[str]:
    """Words of the page in lower case, with the endings of class names or without."""
    return plain() | {
        word.lower() for row in rows() if endings or row.section != ENDINGS for word in row.words
    }


def plain() -> set[str]:
    """Words in lower case that names use as a dictionary has them."""
    return {word.lower() for word in re.findall(r"\*(\w+)\*", PAGE.read_text().partition(f"## {PLAIN}")[2])}


def parts(name: str) -> list[str]:
    """Words of a class's name, in lower case."""
    return [part.lower() for part in re.findall(r"[A-Z][a-z0-9]*", name)]


def classes() -> Mapping[str, list[str]]:
    """Files of the product by the public classes that stand at their top."""
    found = defaultdict(list)
    for root in ROOTS:
        for path in sorted((ROOT / root).rglob("*.py")):
            if "tests" not in path.parts:
                for node in ast.parse(path.read_text()).body:
                    if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                        found[node.name].append(path.relative_to(ROOT).as_posix())
    return found


def unknown(name: str, known: set[str], endings: set[str]) -> list[str]:
    """Words of a class's name that are in no table; an ending counts at the end alone."""
    said = [
        one if (one := SINGULAR.get(part, part.removesuffix("s"))) in known else part for part in parts(name)
    ]
    return [part for part in said[:-1] if part not in known] + [
        part for part in said[-1:] if part not in known | endings
    ]


@pytest.mark.parametrize(
    "row", [row for row in rows() if row.section != ENDINGS], ids=lambda row: row.words[0]
)
def test_a_word_lives_in_the_code(row: Row) -> None:
    mentioned = MENTION.search(row.where)
    if mentioned:
        file, name = mentioned.groups()
        assert is_defined(ROOT / file, name), f"{file} does not define {name}"
    else:
        assert (ROOT / row.where.strip("`")).is_file(), row.where


def test_no_word_has_two_definitions() -> None:
    said = [word.lower() for row in rows() for word in row.words]
    assert len(said) > 80
    assert sorted({word for word in said if said.count(word) > 1}) == []


def test_definitions_are_short() -> None:
    assert [row.words[0] for row in rows() if not row.definition or len(row.definition) > LONGEST] == []


def test_classes_of_the_vocabulary_are_named_by_words() -> None:
    known, endings = words(endings=False), words(endings=True)
    shared = {name: where for name, where in classes().items() if any("hil/vocab/" in path for path in where)}
    assert {name: strange for name in shared if (strange := unknown(name, known, endings))} == {}


def test_plain_words_are_needed_and_have_no_row() -> None:
    shared = [name for name, where in classes().items() if any("hil/vocab/" in path for path in where)]
    used = {part.removesuffix(end) for name in shared for part in parts(name) for end in ("", "s")}
    assert sorted(plain() - used) == []
    assert sorted(plain() & {word.lower() for row in rows() for word in row.words}) == []


def test_the_page_is_short() -> None:
    verbs = [word for row in rows() if row.section == VERBS for word in row.words]
    assert len(verbs) <= VERBS_MOST
    assert len([word for row in rows() for word in row.words]) - len(verbs) <= NOUNS_MOST


@pytest.mark.parametrize("row", [row for row in rows() if row.section == VERBS], ids=lambda row: row.words[0])
def test_a_verb_is_what_its_place_in_the_code_does(row: Row) -> None:
    (verb,) = row.words
    assert re.search(rf"\b{verb.replace(' ', '_')}\w*`$", row.where)


def test_to_take_is_rare() -> None:
    """``take`` once was anything: to feed, to drain, to apply, to reserve. It is to remove the next, or all
    of one."""
    listed = [path for root in ROOTS for path in (ROOT / root).rglob("*.py*") if "tests" not in path.parts]
    texts = {path.name: path.read_text() for path in listed if path.suffix in (".py", ".pyi")}
    named = [name for name, text in texts.items() if "def take(" in text]
    assert len(named) <= TAKES_MOST, named


def test_rooms_are_named_by_words_or_in_the_layout() -> None:
    layout = (ROOT / "CONTRIBUTING.md").read_text().partition("\n## Commands")[0]
    known = words(endings=False) | set(re.findall(r"^\| `hil/(\w+)`", layout, re.M))
    rooms = [path.parent.name for path in (ROOT / "hil").glob("*/__init__.py")]
    assert len(rooms) > 12
    assert [room for room in rooms if {room, room.removesuffix("s")}.isdisjoint(known)] == []


def test_a_class_that_is_named_by_other_words_is_found() -> None:
    known = {"bench", "clock"}
    assert unknown("BenchClock", known, {"error"}) == []
    assert unknown("BenchError", known, {"error"}) == []
    assert unknown("ErrorBench", known, {"error"}) == ["error"]
    assert unknown("BenchWidget", known, {"error"}) == ["widget"]


def test_no_class_name_twice() -> None:
    assert {n: where for n, where in classes().items() if len(where) > 1 and n not in TWICE} == {}


def test_names_that_may_be_there_twice_are_there() -> None:
    assert sorted(set(TWICE) - set(classes())) == []
