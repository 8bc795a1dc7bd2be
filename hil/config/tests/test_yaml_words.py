"""Syntax errors of YAML and kinds of errors of pydantic: each in words of hil's own."""

import re
from pathlib import Path
from typing import get_args

import pytest
import yaml
from pydantic import ValidationError
from pydantic_core.core_schema import ErrorType

from hil.config.explain import StrictModel, findings_of, words_of
from hil.config.yaml_text import document_from_yaml
from hil.vocab.problem import ConfigError

BLOCK = "only a digit 1 to 9, + or - can follow | or > (begin the text on the next line, indented)"
TAG = "this tag is not complete (remove it; text that begins with ! wants quotes)"
WORDS = [
    ("m1:\n  profile:sac\n  baud: 3\n", '2:11: there is no space after the colon (write "profile: sac")'),
    ("bench:t\nm1:\n  a: 1\n", '1:7: there is no space after the colon (write "bench: t")'),
    ("m1:\n    a: 1\n   b: 2\n", "3:4: this line is indented by 3 spaces, which fits no line above"
     " (indent it by 4 spaces, as line 2, or by no spaces, as line 1)"),
    ("a: 1\n  b: 2\n", "2:3: this line is indented below line 1, which has a value already"
     " (indent it by no spaces, as that line)"),
    ("m1:\n  - a\n  b: 2\n", "3:3: a key stands among the items of the list that begin in line 2"
     ' (begin it with "- ", or indent the list deeper)'),
    ("- a: 1\n b: 2\n", "2:2: this line is indented by 1 space, which fits no line above"
     " (indent it by no spaces, as line 1)"),
    ("a: {b: 1\n", '1:4: nothing closes this "{" (write "}")'),
    ("a: [b,\n", "2:1: a value is wanted here, not the end of the file"
     " (write it, or quotes around the text)"),
    ("a: [b\n", '1:4: nothing closes this "[" (write "]")'),
    ("x: {a: 1]\n", '1:9: a comma or "}" is wanted here, not "]" (check brackets, commas and quotes here)'),
    ("x: [a}\n", '1:6: a comma or "]" is wanted here, not "}" (check brackets, commas and quotes here)'),
    ("{a: b: c}", '1:6: a comma or "}" is wanted here, not ":" (check brackets, commas and quotes here)'),
    ("a: {b: 1,, c: 2}", '1:10: a value is wanted here, not "," (write it, or quotes around the text)'),
    ("a: [1]]\n", '1:7: this "]" belongs to no bracket (remove it, or open what it closes)'),
    ("a: ]", '1:4: a value is wanted here, not "]" (write it, or quotes around the text)'),
    ("a: 'x' y\n",
     "1:8: there is text behind the end of the value (put the whole text in one pair of quotes)"),
    ("a: 'x\n", "1:4: this text in quotes has no end (write the same quote behind it)"),
    ('a: "x\n---\ny"', "2:1: a line --- or ... stands inside a text in quotes (close the quotes before it)"),
    ("a: 1\nb\nc: 1\n", "2:1: there is no colon after this key (write a colon and a space after it)"),
    ("{a: 1}\nb: 2\n", "2:1: nothing more is wanted here: what begins the file has ended"
     " (check what is before it: a bracket, a brace or a quote too many or too few)"),
    ("a: @x\n", '1:4: text cannot begin with "@" (put the text in quotes)'),
    ("a: `x\n", '1:4: text cannot begin with "`" (put the text in quotes)'),
    ("a: %x\n", '1:4: text cannot begin with "%" (put the text in quotes)'),
    ("a: 1\n\tb: 3\n", "2:1: a tab stands where YAML wants spaces (indent with spaces, not with tabs)"),
    ('a: "\\d"\n', "1:6: \\d is no escape of YAML (write \\\\ for \\, or use single quotes)"),
    ('a: "\\x1"\n', "1:7: this escape has too few hexadecimal digits"
     " (write \\xHH, \\uHHHH or \\UHHHHHHHH; in single quotes \\ is a plain character)"),
    ("a: |x\n", f"1:5: {BLOCK}"),
    ("a: |0\n x", f"1:5: {BLOCK}"),
    ("a: !%ff b\n", "1:5: this tag is not complete (remove it; text that begins with ! wants quotes)"),
    ("a: >-x\n", f"1:6: {BLOCK}"),
    ("a: & b\n", "1:5: a name of letters and digits is wanted behind & or *"
     " (text that begins with & or * wants quotes)"),
    ("a: *\n", "1:5: a name of letters and digits is wanted behind & or *"
     " (text that begins with & or * wants quotes)"),
    ("a: *x\n", '1:4: there is no anchor "x" (an alias (*name) wants its anchor (&name) further up)'),
    ("a: &x 1\nb: &x 2\n", "2:4: this anchor is given twice (give each anchor a name of its own)"),
    *((text, f"{at}: {TAG}") for text, at in (
        ("a: !<x b\n", "1:7"), ("a: !e!x b\n", "1:4"), ("a: !x%zz b\n", "1:7"), ("a: !<> b", "1:6"))),
    *((text, f"{at}: this line begins with %, which YAML keeps for directives"
       " (remove it; text that begins with % wants quotes)") for text, at in (
        ("%YAML 2.0\n---\na: 1", "1:1"), ("%YAML x\n---\na", "1:7"), ("%YAML 1.1\n%YAML 1.1\n---\na", "2:1"),
        ("%TAG ! x\n%TAG ! y\n---\na", "2:1"), ("%!\n---\n", "1:2"), ("%YAML 1.1 x\n---\n", "1:11"),
        ("%TAG x\n---\n", "1:6"), ("%YAML 1;1\n---\n", "1:8"))),
    ("a: - b\n",
     "1:4: an item of a list cannot begin here (begin the list in a line of its own, below its key)"),
    ("? - a\n? b: ? c\n", "2:6: a key cannot begin here (begin the key in a line of its own)"),
    ("a: b: c", '1:5: a colon cannot stand here: "key: value" begins a line of its own'
     " (check the indentation; text with a colon in it wants quotes)"),
    ("a: 1\n---\nb: 2\n",
     "2:1: a second document begins here (keep one document in a file: remove the line ---)"),
    ("a: \x07", "1:4: the character U+0007 is not allowed"
     " (remove it; in double quotes it can be written as an escape)"),
]  # fmt: skip
FOREIGN = re.compile("expected|found|while |token|stream|scalar|flow|block|mapping|sequence|Input|should")


@pytest.mark.parametrize(("text", "problem"), WORDS)
def test_syntax_errors(text: str, problem: str) -> None:
    with pytest.raises(ConfigError) as caught:
        document_from_yaml(text, "b.yaml")
    (found,) = map(str, caught.value.problems)
    assert found == f"b.yaml:{problem}"
    assert not FOREIGN.search(found)


def test_each_complaint_of_the_parser_has_words() -> None:
    """PyYAML's own sources say what it can complain of."""
    told = set()
    for text, _ in WORDS:
        try:
            yaml.compose(text, yaml.SafeLoader)
        except yaml.MarkedYAMLError as error:
            told.add(_pattern(error.problem or ""))
        except yaml.YAMLError:
            continue
    folder = Path(yaml.__file__).parent
    source = "".join((folder / name).read_text() for name in ("scanner.py", "parser.py", "composer.py"))
    raised = re.findall(
        r"raise (?:Scanner|Parser|Composer)Error\((.*?)(?:get_mark\(\)|_mark|, mark)\)", source, re.S
    )
    problems = {_pattern(found) for each in raised for found in re.findall(r'"([^"]+)"', each)[-1:]}
    assert {each for each in problems if not any(_alike(each, other) for other in told)} <= UNTOLD


UNTOLD = {
    "invalid indentation or unclosed or",  # a comment of theirs
    "Please check and share your opinion.",  # another
    "while scanning a",  # its problem is the text of a UnicodeDecodeError; the table goes by this context
}


def _pattern(text: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"%[rds]|'.*?'|\"", "", text)).strip()


def _alike(one: str, other: str) -> bool:
    return one[:16] == other[:16]


@pytest.mark.parametrize("kind", get_args(ErrorType))
def test_kinds_of_errors_of_pydantic(kind: str) -> None:
    context = {"ge": 1, "gt": 1, "le": 1, "lt": 1, "expected": "'a' or 'b'", "pattern": "^x$"}
    context |= {"actual_length": 2, "max_length": 1}
    theirs = "Value error, it is odd" if kind.startswith("value_") else "Assertion failed, it is odd"
    message, remedy = words_of({"type": kind, "input": "x", "ctx": context, "msg": theirs, "loc": ()}, "x")
    assert remedy
    assert not re.search("Input|should|error|Assertion|instance|valid|odd.*odd", message)


def test_characters_are_shown_as_they_are() -> None:
    class Named(StrictModel):
        name: int

    document = document_from_yaml("name: bäd\nnäme: 3\n", "b.yaml")
    with pytest.raises(ValidationError) as caught:
        Named.model_validate(document.value)
    said = {(each.message, each.remedy) for each in findings_of(caught.value, Named, (), document)}
    assert said == {
        ('a whole number is wanted here, not "bäd"', "write a whole number"),
        ("unknown key", 'did you mean "name"?'),
    }
