"""Checks the prose of the project: ``make lint``.

It reads the pages (``*.md``) and, in Python files, the docstrings and all texts of two words or more: help
texts and messages. It leaves out code, in blocks and in sentences. The rules are those of proselint, and the
terms of ``prose.toml``. A finding is a line ``file:line:column: rule: message``.
"""

import ast
import re
import subprocess
import sys
import tomllib
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from proselint import checks
from proselint.config import DEFAULT, Config
from proselint.registry import CheckRegistry
from proselint.tools import LintFile

ROOT = Path(__file__).parent
RULES = ROOT / "prose.toml"
UNSEEN = {"tests", "benchmarks"}
"""Folders of which users see nothing."""
CODE = "\N{MIDDLE DOT}"
"""Stands for each letter of code in a sentence: no rule finds words there, and columns stay what they are."""

_BLOCK = re.compile(r"^ *(```|~~~).*?^ *\1$|<!--.*?-->", re.M | re.S)
_INLINE = re.compile(r"``[^`]+``|`[^`]+`|(?<=\])\([^)\s]+\)|https?://\S+|\*\*|\{[^{}\n]*\}")
_QUOTES = re.compile(r"\b[rbfuRBFU]{1,2}(?=[\"'])|\"|(?<!\w)'|\\[nrt]")
_WORDS = re.compile(r"[A-Za-z]{2,}[,:;]? [A-Za-z]{2,}")


class Finding(NamedTuple):
    """A place in a file, and what is wrong there."""

    file: str
    line: int
    column: int
    rule: str
    message: str
    text: str
    """Prose of the line."""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.rule}: {self.message}"


class Allowed(NamedTuple):
    """A rule that does not hold for a text, in one file or in all, and why."""

    rule: str
    text: str
    file: str
    reason: str

    def allows(self, finding: Finding) -> bool:
        """True if it holds for a finding."""
        return (
            finding.rule.startswith(self.rule)
            and self.text.lower() in finding.text.lower()
            and self.file in ("", finding.file)
        )


class Rules(NamedTuple):
    """Terms of our own by their patterns, with what to write instead; proselint's; the exceptions."""

    terms: Mapping[str, str]
    longest: int
    """Maximum number of words of a sentence; a colon or semicolon ends one, too."""
    proselint: Config
    exceptions: Sequence[Allowed]


def read_rules(text: str) -> Rules:
    """Read the rules. Raises KeyError: an exception without a reason; TOMLDecodeError: no TOML."""
    read = tomllib.loads(text)
    enabled = DEFAULT["checks"] | dict.fromkeys(read["off"], False)
    # The first that is the beginning of a check's name decides.
    enabled = dict(sorted(enabled.items(), key=lambda check: -check[0].count(".")))
    exceptions = [
        Allowed(each["rule"], each["text"], each.get("file", ""), each["reason"])
        for each in read.get("exceptions", ())
    ]
    return Rules(
        read["terms"],
        read["longest_sentence_words"],
        {"max_errors": sys.maxsize, "checks": enabled},
        exceptions,
    )


def _blank(text: str, sign: str = " ") -> str:
    return re.sub(r"[^\n]", sign, text)


def _without_code(text: str) -> str:
    return _INLINE.sub(lambda found: _blank(found[0], CODE), text)


def page_prose(text: str) -> str:
    """Sentences of a page at their places; all else is blank."""
    return _without_code(_BLOCK.sub(lambda found: _blank(found[0]), text))


def python_prose(text: str) -> str:
    """Docstrings and texts of a Python file at their places; all else is blank."""
    source = text.encode()
    starts = [0, *(end.end() for end in re.finditer(rb"\n", source))]
    prose = bytearray(re.sub(rb"[^\n]", b" ", source))
    for node in _texts(ast.parse(text)):
        begin = starts[node.lineno - 1] + node.col_offset
        end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
        prose[begin:end] = source[begin:end]
    return _without_code(_QUOTES.sub(lambda found: _blank(found[0], CODE), prose.decode()))


def _texts(node: ast.AST) -> Iterator[ast.expr]:
    """Texts of a syntax tree that have words; one with values in it is one text."""
    match node:
        case ast.JoinedStr():
            said = "".join(str(part.value) for part in node.values if isinstance(part, ast.Constant))
            if _WORDS.search(said):
                yield node
        case ast.Constant(value=str(said)) if _WORDS.search(said):
            yield node
        case _:
            for child in ast.iter_child_nodes(node):
                yield from _texts(child)


class Prose:
    """Prose of several files as one text: proselint takes as long for a short text as for a long one."""

    def __init__(self, texts: Mapping[str, str]) -> None:
        self._places: list[tuple[str, int]] = []
        lines: list[str] = []
        for file, text in texts.items():
            prose = python_prose(text) if file.endswith(".py") else page_prose(text)
            for number, line in enumerate([*prose.split("\n"), ""], 1):
                if line.strip() or (lines and lines[-1]):
                    lines.append(line.rstrip().replace('"', CODE))  # proselint leaves out what is quoted
                    self._places.append((file, number))
        self._lines = lines
        self.text = "\n".join(lines)
        self._starts = [0, *(end.end() for end in re.finditer("\n", self.text))]

    def finding(self, at: int, rule: str, message: str) -> Finding:
        """Make a finding at a place in the text."""
        index = bisect_right(self._starts, at) - 1
        file, line = self._places[index]
        return Finding(file, line, at - self._starts[index] + 1, rule, message, self._lines[index])


def _sentence(words: int) -> str:
    """Pattern of so many words without an end: a sign, a cell, an item, a heading, an empty line, a text."""
    word = rf"(?=\S*\w)[^\s|]+(?<![.:;?!])(?<![.:;?!][){CODE}])"
    gap = rf"(?<!\w{CODE})(?: +|\n *(?![-*#|]|\d+\.|\n))(?!{CODE}\w)"
    return rf"(?<!\S)(?:{word}{gap}){{{words - 1}}}[^\s|]+"


def findings(prose: Prose, rules: Rules) -> list[Finding]:
    """All that the rules find, in the order of the files and lines of each kind of rule."""
    found = []
    for term, instead in rules.terms.items():
        spaced = term.replace(" ", rf"(?: +|[ {CODE}]*\n[ {CODE}]*)")
        for match in re.finditer(rf"(?<![\w-]){spaced}(?![\w-])", prose.text, re.I):
            found.append(prose.finding(match.start(), "term", f"'{match[0]}': write {instead}"))
    for match in re.finditer(_sentence(rules.longest + 1), prose.text):
        found.append(prose.finding(match.start(), "long", f"a sentence of more than {rules.longest} words"))
    registry = CheckRegistry()
    if not registry.checks:
        registry.register_many(checks.__register__)
    for result in LintFile("", prose.text or "\n").lint(rules.proselint):
        check = result.check_result
        if prose.text[check.span[1] - 2 : check.span[1]].isalpha():
            continue  # its phrase ends within a word: "for ever" is none in "for every"
        found.append(prose.finding(check.span[0] - 1, check.check_path, check.message))
    return found


def report(found: Iterable[Finding], exceptions: Sequence[Allowed]) -> list[str]:
    """Lines of the findings that no exception allows, and of the exceptions that nothing needs."""
    lines, used = [], set()
    for finding in found:
        allowed = [exception for exception in exceptions if exception.allows(finding)]
        used.update(allowed)
        if not allowed:
            lines.append(str(finding))
    return lines + [f"prose.toml: nothing needs {each}" for each in exceptions if each not in used]


def tracked() -> dict[str, str]:
    """Texts of the pages and Python files that users and readers see."""
    listed = ["git", "ls-files", "*.md", "*.py"]
    names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    return {name: (ROOT / name).read_text() for name in names if not UNSEEN & set(Path(name).parts[:-1])}


if __name__ == "__main__":
    rules = read_rules(RULES.read_text())
    problems = report(findings(Prose(tracked()), rules), rules.exceptions)
    print(*problems, sep="\n", end="\n" if problems else "")
    sys.exit(1 if problems else 0)
