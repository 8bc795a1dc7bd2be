"""Reader of YAML text: plain values with their places, and findings where YAML would hide a mistake.

PyYAML reads YAML 1.1: it takes ``on`` for true, ``0660`` for 432 and silently the last of two equal
keys. Those are findings here.
"""

import re
from contextlib import suppress

import yaml
from yaml.composer import Composer
from yaml.resolver import Resolver

from hil.config.document import MAX_DEPTH, NUL, Document, Finding, KeyPath, Spot, is_unicode
from hil.config.yaml_words import ODD_SPACE, ODD_SPACES, indented_oddly, syntax_problem, unreadable_character
from hil.vocab.problem import ConfigError, Problem

_TAG = "tag:yaml.org,2002:"
_TEXT_TAGS = {"str", "timestamp", "value", "merge"}
_MAX_NUMBER_CHARACTERS = 100
_TRUE = {"yes", "true", "on"}
_FALSE = {"no", "false", "off"}


_OTHERWISE = re.compile(r"""[!?|>"]|---|(?<!\w)'""")
_ODD = re.compile("[\t\ufeff\x85\u2028\u2029]")
"""Signs and characters that libyaml and PyYAML's own parser do not read alike: whether it is YAML at all, and
where a value is empty. Of the signs those outside of quotes, and quotes that are not plainly such."""
_QUOTED = re.compile(
    r"""(?m)(?:^ *(?:- +)?|: +|[,\[{] *)(?:"(?:[^"\\\n]|\\.)*"|'(?:[^'\n]|\'\')*')|(?:^| )\#.*"""
)
"""Text in quotes, where a value begins, on one line; or a comment."""


class _Nodes(Composer, Resolver):
    """Composer of events to nodes; with a parser that gives the events, a loader."""

    depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        # Without this bound a line of opening brackets ends in a RecursionError.
        if self.depth > MAX_DEPTH:
            mark = self.peek_event().start_mark  # type: ignore[attr-defined]
            raise yaml.MarkedYAMLError(problem=f"nested more than {MAX_DEPTH} deep", problem_mark=mark)
        self.depth += 1
        node: yaml.Node | None = super().compose_node(parent, index)
        self.depth -= 1
        return node


# YAML 1.1 takes 5e-6 for text, because it has no point; everybody else takes it for a number.
_Nodes.add_implicit_resolver(
    _TAG + "float", re.compile(r"[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


class _Loader(_Nodes, yaml.SafeLoader):
    """Loader that knows what is wrong, and where; takes ten times as long as the other."""


if yaml.__with_libyaml__:
    from yaml._yaml import CParser

    class _FastLoader(_Nodes, CParser):
        """Loader with libyaml's parser, where PyYAML came with it, as all its wheels do."""

        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            Composer.__init__(self)
            Resolver.__init__(self)


def document_from_yaml(text: str, file: str) -> Document:
    """Read one YAML document; ``value`` is None for an empty one.

    Raises:
        ConfigError: the text is not YAML.
    """
    document = Document(file, values={(): Spot(1, 1)})
    node = _compose(text, file)
    if node is not None:
        document.value = _value(document, (), node)
    if any(str(key[-1])[:1] in ODD_SPACES for key in document.keys):
        raise ConfigError([Problem(file, at.line, at.column, *ODD_SPACE) for at in indented_oddly(text)])
    return document


def _compose(text: str, file: str) -> yaml.Node | None:
    if yaml.__with_libyaml__ and not _ODD.search(text) and not _OTHERWISE.search(_QUOTED.sub(" ", text)):
        with suppress(yaml.YAMLError, ValueError, OverflowError):
            return _FastLoader(text).get_single_node()
    return _compose_slowly(text, file)


def _compose_slowly(text: str, file: str) -> yaml.Node | None:
    loader = None
    try:
        loader = _Loader(text)
        return loader.get_single_node()
    except yaml.reader.ReaderError as error:
        if NUL in text:
            why = Problem(file, 1, 1, "this is no text file", "give a text, saved as UTF-8")
            raise ConfigError([why]) from None
        before = text[: error.position]
        spot = Spot(before.count("\n") + 1, len(before) - before.rfind("\n"))
        message, remedy = unreadable_character(text[error.position])
    except yaml.MarkedYAMLError as error:
        raise ConfigError([syntax_problem(error, text, file)]) from None
    except (ValueError, OverflowError):
        # PyYAML lets these through from escapes and directives whose number is out of range.
        spot = Spot(loader.line + 1, loader.column + 1) if loader else Spot(1, 1)
        message, remedy = "a number here is out of range", "check the escapes (\\U...) on this line"
    finally:
        if loader is not None:
            loader.dispose()
    raise ConfigError([Problem(file, spot.line, spot.column, message, remedy)])


def _value(document: Document, path: KeyPath, node: yaml.Node) -> object:
    if not document.enter(path, _spot(node)):
        return None
    match node:
        case yaml.MappingNode(tag="tag:yaml.org,2002:map"):
            return _mapping(document, path, node)
        case yaml.SequenceNode(tag="tag:yaml.org,2002:seq"):
            return [_value(document, (*path, index), item) for index, item in enumerate(node.value)]
        case yaml.ScalarNode():
            document.raw[path] = node.value
            if node.style == "|" and (spot := _block_spot(node)):
                document.blocks[path] = spot
            return _scalar(document, path, node)
    document.find(path, f"the tag {_tag(node)} is not used here", "remove the tag")
    return None


def _mapping(document: Document, path: KeyPath, node: yaml.MappingNode) -> dict[str, object]:
    result: dict[str, object] = {}
    before: yaml.Node | None = None
    for key_node, value_node in node.value:
        name = key_node.value
        spot = _spot(key_node)
        if node.flow_style and before is not None and _is_decimals(before, key_node, value_node):
            message = f'"{before.value},{name}" has a comma'
            remedy = f"write a point before decimals, as {before.value}.{name}"
            document.findings.append(Finding((*path, *list(result)[-1:]), message, remedy))
            continue
        before = value_node
        if not isinstance(name, str) or not is_unicode(name):
            document.findings.append(
                Finding(path, "a key must be a name", "write a plain name before the colon", spot=spot)
            )
            continue
        here = (*path, name)
        if here in document.keys:
            message = f"this key is given twice, first in line {document.keys[here].line}"
            document.findings.append(Finding(here, message, "keep one of the two", spot=spot))
            continue
        document.keys[here] = spot
        document.findings += _key_findings(here, name, key_node.tag)
        result[name] = _value(document, here, value_node)
    return result


def _is_decimals(before: yaml.Node, key: yaml.Node, value: yaml.Node) -> bool:
    """True for the decimals of ``{m1: 1,5}``: digits at once behind a number and its comma, without a value
    of their own."""
    numbers = (f"{_TAG}int", f"{_TAG}float")
    return (
        before.tag in numbers
        and isinstance(key.value, str)
        and key.value.isdecimal()
        and value.tag == f"{_TAG}null"
        and not value.value
        and key.start_mark.line == before.end_mark.line
        and key.start_mark.column == before.end_mark.column + 1
    )


def _key_findings(path: KeyPath, name: str, tag: str) -> list[Finding]:
    kind = tag.removeprefix(_TAG)
    if kind == "merge":
        return [Finding(path, "keys cannot be merged in with <<", "write them out", at_key=True)]
    if kind in _TEXT_TAGS:
        return []
    meaning = {
        "bool": "the truth value " + ("true" if name.lower() in _TRUE else "false"),
        "int": "a number",
        "float": "a number",
        "null": "nothing",
    }.get(kind, f"a value of type {kind}")
    quotable = re.fullmatch("[A-Za-z][A-Za-z0-9_-]*", name)
    remedy = f'write it in quotes: "{name}"' if quotable else "a name begins with a letter, as in m1"
    if path[-2:-1] == ("objects",) and re.fullmatch("[0-9]{4}", name):
        remedy = f"write it with an h behind it: {name}h"  # an index of CANopen, in base 16
    return [Finding(path, f"YAML takes this key for {meaning}, not for a name", remedy, at_key=True)]


def _scalar(document: Document, path: KeyPath, node: yaml.ScalarNode) -> object:
    text: str = node.value
    kind = node.tag.removeprefix(_TAG)
    # 1:30 is 90 to YAML 1.1, in base 60; nobody means that.
    if kind in _TEXT_TAGS or (kind in ("int", "float") and ":" in text):
        return document.scalar(path, text)
    if kind == "null":
        return None
    if kind == "bool" and text.lower() in _TRUE | _FALSE:
        return text.lower() in _TRUE
    if kind in ("int", "float"):
        return _number(document, path, text, kind)
    document.find(path, f"the tag {_tag(node)} does not fit here", "remove the tag")
    return None


def _number(document: Document, path: KeyPath, text: str, kind: str) -> object:
    plain = text.replace("_", "").lower()
    if len(text) > _MAX_NUMBER_CHARACTERS:
        document.find(path, "is too long for a number", "write fewer digits")
        return None
    if kind == "int" and re.fullmatch("[-+]?0[0-7]+", plain):
        remedy = f'write {plain.lstrip("+0") or 0} for the number, or "{text}" in quotes for a text'
        message = f"{text} is a number in base 8 to YAML: {int(plain, 8)}"
        document.find(path, message, remedy)
        return None
    try:
        number = (
            int(plain, 0) if kind == "int" else float(plain.replace(".inf", "inf").replace(".nan", "nan"))
        )
    except ValueError:
        document.find(path, f"{text!r} is not a number", "write a number")
        return None
    return document.scalar(path, number)


def _block_spot(node: yaml.ScalarNode) -> Spot | None:
    """Place of the first line of a literal block; None: it begins with an empty one, or has none."""
    mark = node.start_mark
    lines = (mark.buffer or "")[mark.pointer :].split("\n", 2)
    if len(lines) < 2 or not (text := lines[1]).strip():
        return None
    return Spot(mark.line + 2, len(text) - len(text.lstrip(" ")) + 1)


def _spot(node: yaml.Node) -> Spot:
    return Spot(node.start_mark.line + 1, node.start_mark.column + 1)


def _tag(node: yaml.Node) -> str:
    """Tag of a node as an author writes it."""
    tag: str = node.tag
    return "!!" + tag.removeprefix(_TAG) if tag.startswith(_TAG) else tag
