"""Lines about commands, JSON each, and the chain of hashes that joins them: a line that was changed, or taken
out from between two, shows.

Each line ends in ``chain``: the SHA-256, in hexadecimal digits, of the chain of the line before, a line feed,
and the line without its own ``chain``. A line with ``begins`` stands where a bench began to write; its
``after`` is the chain that it goes on from, empty if there was none.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from hashlib import sha256
from typing import Any, NamedTuple

from hil.wire.json_text import JsonError, read_json

COMMANDS = "commands"
"""Name of the folder with the files of days in a bench's state directory."""
BEGINS, AFTER = "begins", "after"
VERSION = 1
"""Version of the lines, ``v`` in each."""
_CHAIN = re.compile(r',"chain":"([0-9a-f]{64})"\}\Z')
LINE_BYTES = 64 * 1024
"""Maximum length of a line: a signed payload has the most of it."""
_TEXT = 240


class ChainedLine(NamedTuple):
    """Line without its line feed, and its ``chain``."""

    text: str
    chain: str


def chained(row: Mapping[str, Any], before: str) -> ChainedLine:
    """Make a line. ``before``: chain of the line before, empty for the first."""
    text = json.dumps({"v": VERSION, **row}, separators=(",", ":"))
    chain = _hash(before, text)
    return ChainedLine(f'{text[:-1]},"chain":"{chain}"}}', chain)


def command_words(row: Mapping[str, Any]) -> str:
    """Format a line's content for people: ann at zenoh, m1: move_abs position_deg 90: done."""
    if BEGINS in row:
        return f"{row[BEGINS]} began, bench {row.get('bench', '')}"
    given = row.get("given", {})
    values = ", ".join(f"{name} {value}" for name, value in given.items()) if isinstance(given, dict) else ""
    who = f"{row['user']} at {row.get('door', '')}" if row.get("user") else str(row.get("door", ""))
    what = " ".join(filter(None, (str(row.get("operation", "")), values)))
    on = f" {row['target']}:" if row.get("target") else ""
    times = f", {row['count']} times" if row.get("count") else ""
    why = f": {row['why']}" if row.get("why") else ""
    return f"{who}:{on} {what}{times}: {row.get('outcome', '')}{why}"[:_TEXT]


def _hash(before: str, text: str) -> str:
    return sha256(f"{before}\n{text}".encode()).hexdigest()


def chain_of(text: str) -> str:
    """Read the chain at a line's end; empty: there is none."""
    found = _CHAIN.search(text)
    return found[1] if found else ""


class CheckedLine(NamedTuple):
    """Line as it was read. ``row``: its content, empty if it is none; ``wrong``: what is wrong with it or its
    place, empty if it follows the line before."""

    row: Mapping[str, Any]
    wrong: str = ""


def checked_lines(texts: Iterable[str]) -> Iterator[CheckedLine]:
    """Read lines in their order and check the chain. The first may go on from a line that is not here."""
    before: str | None = None
    for text in texts:
        chain, row = chain_of(text), _row(text)
        if not chain or not row:
            yield CheckedLine({}, "it is no whole line about a command")
            continue
        after = str(row.get(AFTER, "")) if BEGINS in row else before
        if after is None:
            wrong = "the line before it is not here"
        elif before not in (None, after):
            wrong = "lines before it are missing"
        elif _hash(after, _CHAIN.sub("}", text)) != chain:
            wrong = "it was changed, or lines before it are missing"
        else:
            wrong = ""
        before = chain
        yield CheckedLine(row, wrong)


def _row(text: str) -> Mapping[str, Any]:
    try:
        row = read_json(text.encode())
    except (JsonError, UnicodeEncodeError):
        return {}
    return row if isinstance(row, dict) else {}
