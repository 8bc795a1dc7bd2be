"""The page of all keywords, from what Robot Framework's libdoc finds: ``make keywords``."""

import re
from collections.abc import Iterator
from typing import Any

from robot import libdoc

LIBRARY = "hil.robot"


def keyword_page() -> str:
    """Write ``docs/robot-keywords.md``."""
    document: Any = libdoc.LibraryDocumentation  # type: ignore[attr-defined,unused-ignore]
    found = document(LIBRARY)
    (start,) = found.inits
    parts = [
        "# Keywords of Robot Framework",
        "<!-- Written by `make keywords`. -->",
        "[How to use them](how-to/robot.md). `python -m robot.libdoc hil.robot keywords.html` writes a page"
        " that can be searched.",
        _markdown(found.doc),
        f"`Library    {LIBRARY}    {_arguments(start)}`",
    ]
    for each in found.keywords:
        parts += [
            f"## {each.name}",
            f"`{each.name}    {_arguments(each)}`".replace("    `", "`"),
            _markdown(each.doc),
        ]
    return "\n\n".join(parts) + "\n"


def _arguments(keyword: Any) -> str:
    return "    ".join(map(str, keyword.args))


def _markdown(doc: str) -> str:
    """Text of the same in Markdown: rows of a table in Robot Framework's format are suites here."""
    return "\n\n".join(_paragraphs(doc))


def _paragraphs(doc: str) -> Iterator[str]:
    for part in doc.strip().split("\n\n"):
        if part.startswith("| "):
            rows = "\n".join(row.removeprefix("| ") for row in part.splitlines())
            yield f"```robotframework\n{rows}\n```"
        else:
            yield re.sub(r"(?<!`)`([A-Z][\w ]+)`(?!`)", _link, part).replace("``", "`")


def _link(named: re.Match[str]) -> str:
    return f"[{named[1]}](#{named[1].lower().replace(' ', '-')})"


if __name__ == "__main__":
    print(keyword_page(), end="")
