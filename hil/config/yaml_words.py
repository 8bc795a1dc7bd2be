"""YAML's syntax errors in the words of a configuration file's author."""

import re

import yaml

from hil.config.document import Spot
from hil.vocab.late_dataclass import dataclass
from hil.vocab.problem import Problem

_QUOTES = "text that begins with {} wants quotes"
_DIRECTIVE = "this line begins with %, which YAML keeps for directives", f"remove it; {_QUOTES.format('%')}"
_TAG = "this tag is not complete", f"remove it; {_QUOTES.format('!')}"
_BLOCK_TEXT = "only a digit 1 to 9, + or - can follow | or >", "begin the text on the next line, indented"
_BETWEEN = "check what is before it: a bracket, a brace or a quote too many or too few"
_WORDS = (
    (r"found character '\\t'", "a tab stands where YAML wants spaces", "indent with spaces, not with tabs"),
    (r"found character '(?P<sign>.)' that cannot start any token",
     'text cannot begin with "{sign}"', "put the text in quotes"),
    ("sequence entries are not allowed", "an item of a list cannot begin here",
     "begin the list in a line of its own, below its key"),
    ("mapping keys are not allowed", "a key cannot begin here", "begin the key in a line of its own"),
    ("mapping values are not allowed", 'a colon cannot stand here: "key: value" begins a line of its own',
     "check the indentation; text with a colon in it wants quotes"),
    ("directive", *_DIRECTIVE),
    ("incompatible YAML document", *_DIRECTIVE),
    ("duplicate tag handle", *_DIRECTIVE),
    ("scanning an (?:anchor|alias)", "a name of letters and digits is wanted behind & or *",
     _QUOTES.format("& or *")),
    ("(?:parsing|scanning) an? tag|undefined tag handle", *_TAG),
    ("block scalar", *_BLOCK_TEXT),
    ("escape sequence of", "this escape has too few hexadecimal digits",
     r"write \xHH, \uHHHH or \UHHHHHHHH; in single quotes \ is a plain character"),
    ("unknown escape character '(?P<sign>.+)'", r"\{sign} is no escape of YAML",
     r"write \\ for \, or use single quotes"),
    ("unexpected document separator", "a line --- or ... stands inside a text in quotes",
     "close the quotes before it"),
    ("expected '<document start>'", "nothing more is wanted here: what begins the file has ended", _BETWEEN),
    ("found undefined alias '(?P<sign>.+)'", 'there is no anchor "{sign}"',
     "an alias (*name) wants its anchor (&name) further up"),
    ("duplicate anchor|second occurrence", "this anchor is given twice",
     "give each anchor a name of its own"),
    ("but found another document", "a second document begins here",
     "keep one document in a file: remove the line ---"),
    ("nested more", "{problem}", "no key is nested so deep"),
)  # fmt: skip
"""Rows of the parser's words (its context and its problem), our message, and the remedy."""
_TOKENS = {
    "<stream end>": "the end of the file",
    "<block end>": "the end of the indented lines",
    "<block mapping start>": "a key",
    "<block sequence start>": "a list",
    "<scalar>": "text",
    "?": "a key",
    "-": "an item of a list",
    "<document start>": "---",
    "<document end>": "...",
}
ODD_SPACES = tuple("\u00a0\u2002\u2003\u2007\u2009\u202f\u3000")
"""Spaces that look like plain ones, as a web page or a word processor has them."""
ODD_SPACE = (
    "a space that is none to YAML (U+00A0 or the like) stands here, as copied from a web page",
    "write plain spaces",
)
_ODDLY = re.compile(f"^ *[{''.join(ODD_SPACES)}]", re.M)
_NO_SPACE = re.compile(r"""^\s*(?:-\s+)?(?P<key>[A-Za-z_][\w.-]*):(?P<value>[^\s:/"'][^:]*|"[^"]*")$""")


@dataclass(frozen=True)
class _Words:
    """Message with its remedy. ``spot`` overrides the place where the parser stopped."""

    message: str
    remedy: str
    spot: Spot | None = None


def syntax_problem(error: yaml.MarkedYAMLError, text: str, file: str) -> Problem:
    """Make a problem of a parser's error about ``text``."""
    mark = error.problem_mark or error.context_mark
    stopped = _spot(mark) if mark else Spot(1, 1)
    words = (
        _no_space(error, text, stopped)
        or _no_space_after_dash(error, text, stopped)
        or _too_deep(error, text, stopped)
        or _unclosed(error)
        or _out_of_line(error, text, stopped)
        or _by_table(error)
    )
    at = words.spot or stopped
    return Problem(file, at.line, at.column, words.message, words.remedy)


def unreadable_character(character: str) -> tuple[str, str]:
    """Message and remedy for a character that YAML does not let in."""
    remedy = "remove it; in double quotes it can be written as an escape"
    return f"the character {shown_character(character)} is not allowed", remedy


def shown_character(character: str) -> str:
    """Character as it looks, or by its number if it cannot be seen."""
    return f'"{character}"' if character.isprintable() else f"U+{ord(character):04X}"


def indented_oddly(text: str) -> list[Spot]:
    """Places of the first of such spaces in each line that begins with some."""
    return [
        Spot(text.count("\n", 0, found.start()) + 1, found.end() - found.start())
        for found in _ODDLY.finditer(text)
    ]


def missing_space(text: str) -> str | None:
    """``key: value`` for a text ``key:value``, which YAML takes for one word; None for other texts."""
    found = _NO_SPACE.match(text) if text.isprintable() else None
    return f"{found['key']}: {found['value']}" if found else None


def _spot(mark: yaml.Mark) -> Spot:
    return Spot(mark.line + 1, mark.column + 1)


def _no_space(error: yaml.MarkedYAMLError, text: str, stopped: Spot) -> _Words | None:
    """Words for a key without a space behind its colon, in the line of an error or the one before it."""
    if not re.search("mapping values|expected ':'|<block end>", error.problem or ""):
        return None
    lines = text.split("\n")[: stopped.line]
    while lines and not lines[-1].strip():
        lines.pop()
    for number in (len(lines), len(lines) - 1):
        line = lines[number - 1].partition(" #")[0].rstrip() if number > 0 else ""
        if written := missing_space(line):
            return _Words(
                "there is no space after the colon", f'write "{written}"', Spot(number, line.index(":") + 2)
            )
    return None


def _no_space_after_dash(error: yaml.MarkedYAMLError, text: str, stopped: Spot) -> _Words | None:
    """Words for ``-key: value`` and ``-{key: value}``, which YAML takes for a key that begins with a dash."""
    line = text.split("\n")[stopped.line - 1] if stopped.line <= text.count("\n") + 1 else ""
    if "mapping values" not in (error.problem or "") or not (found := re.match(r"\s*-(?=[^\s-])", line)):
        return None
    written = f"- {line[found.end() :].rstrip()}"
    shown = written if len(written) <= 40 else f"{written[:40]}..."
    return _Words("there is no space after the dash", f'write "{shown}"', Spot(stopped.line, found.end() + 1))


def _too_deep(error: yaml.MarkedYAMLError, text: str, stopped: Spot) -> _Words | None:
    """Words for a key that is indented below a key with a value."""
    if "mapping values" not in (error.problem or ""):
        return None
    indents = _indents(text, stopped.line)
    if len(indents) < 2 or indents[-1][1] <= indents[-2][1] or indents[-1][0] != stopped.line:
        return None
    (line, _), above = indents[-1], indents[-2]
    message = f"this line is indented below line {above[0]}, which has a value already"
    return _Words(message, f"indent it by {_spaces(above[1])}, as that line", Spot(line, indents[-1][1] + 1))


def _indents(text: str, until: int) -> list[tuple[int, int]]:
    """Lines up to one, by their numbers, and by how many spaces each is indented; empty ones are left out."""
    lines = enumerate(text.split("\n")[:until], 1)
    plain = ((number, line.expandtabs(1)) for number, line in lines)
    return [
        (number, len(line) - len(rest))
        for number, line in plain
        if (rest := line.lstrip()) and rest[0] != "#"
    ]


def _spaces(count: int) -> str:
    return "1 space" if count == 1 else f"{count or 'no'} spaces"


def _unclosed(error: yaml.MarkedYAMLError) -> _Words | None:
    """Words for quotes, brackets and braces that the text's end leaves open, and for what stands in them."""
    problem, began = error.problem or "", error.context_mark
    if "unexpected end of stream" in problem and began:
        return _Words("this text in quotes has no end", "write the same quote behind it", _spot(began))
    if "could not find expected ':'" in problem and began:
        return _Words("there is no colon after this key", "write a colon and a space after it", _spot(began))
    if (wanted := re.search(r"expected ',' or '(.)', but got '(.+)'", problem)) and began:
        sign, found = wanted.groups()
        is_below = error.problem_mark and error.problem_mark.line > began.line
        if found == "<stream end>" or (found == ":" and is_below):
            return _Words(
                f'nothing closes this "{"[" if sign == "]" else "{"}"', f'write "{sign}"', _spot(began)
            )
        return _Words(
            f'a comma or "{sign}" is wanted here, not {_token(found)}',
            "check brackets, commas and quotes here",
        )
    return None


def _out_of_line(error: yaml.MarkedYAMLError, text: str, stopped: Spot) -> _Words | None:
    """Words for a line that does not belong to the lines above it, and for a value that is not there."""
    problem, began = error.problem or "", error.context_mark
    if found := re.search("expected the node content, but found '(.+)'", problem):
        return _Words(
            f"a value is wanted here, not {_token(found[1])}", "write it, or quotes around the text"
        )
    if not (found := re.search("expected <block end>, but found '(.+)'", problem)) or not began:
        return None
    is_list = "collection" in (error.context or "")
    if found[1] == "<scalar>":
        return _Words("there is text behind the end of the value", "put the whole text in one pair of quotes")
    if found[1] in ("]", "}", ","):
        return _Words(f'this "{found[1]}" belongs to no bracket', "remove it, or open what it closes")
    if is_list and found[1] == "?" and began.column == stopped.column - 1:
        where = f"the items of the list that begin in line {began.line + 1}"
        return _Words(f"a key stands among {where}", 'begin it with "- ", or indent the list deeper')
    *above, (_, own) = _indents(text, stopped.line)
    last = {indent: line for line, indent in above}
    fitting = [min((each for each in last if each > own), default=None)]
    fitting.append(max((each for each in last if each < own), default=None))
    ways = [f"by {_spaces(each)}, as line {last[each]}" for each in fitting if each is not None]
    return _Words(
        f"this line is indented by {_spaces(own)}, which fits no line above",
        f"indent it {', or '.join(ways)}" if ways else "check the indentation here",
    )


def _by_table(error: yaml.MarkedYAMLError) -> _Words:
    problem = " ".join((error.problem or "").split())
    said = f"{error.context or ''} {problem}"
    for pattern, message, remedy in _WORDS:
        if found := re.search(pattern, said):
            signs = {"sign": found.groupdict().get("sign") or "", "problem": problem}
            return _Words(message.replace("{sign}", signs["sign"]).replace("{problem}", problem), remedy)
    return _Words("this cannot be read as YAML", "check the indentation, brackets and quotes here")


def _token(name: str) -> str:
    return _TOKENS.get(name, f'"{name}"')
