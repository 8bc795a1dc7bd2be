"""A configuration as plain values with their places, which the checks work on and point at."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import field
from pathlib import PurePath

from hil.vocab.late_dataclass import dataclass
from hil.vocab.problem import ConfigError, Problem

KeyPath = tuple[str | int, ...]
"""Path to a value from the top: ``("devices", "m1", "baud")``."""

NUL = "\0"
MAX_DEPTH = 20
MAX_VALUES = 100_000
_INT64 = range(-(2**63), 2**63)


@dataclass(frozen=True, order=True)
class Spot:
    """Place in a file; line and column count from 1, and (0, 0) stands for no text."""

    line: int
    column: int


NOWHERE = Spot(0, 0)


@dataclass(frozen=True)
class Finding:
    """Mistake at a key path. ``spot`` overrides the place that the path stands for."""

    path: KeyPath
    message: str
    remedy: str
    at_key: bool = False
    spot: Spot | None = None


@dataclass
class Document:
    """Document of plain values (dict, list, str, int, float, bool, None) and their places.

    A value that could not be read is None and has a finding at its path.
    """

    file: str
    value: object = None
    keys: dict[KeyPath, Spot] = field(default_factory=dict)
    values: dict[KeyPath, Spot] = field(default_factory=dict)
    raw: dict[KeyPath, str] = field(default_factory=dict)
    """Texts of scalars as they were written."""
    blocks: dict[KeyPath, Spot] = field(default_factory=dict)
    """Places of the first lines of texts that stand in lines of their own (``|``)."""
    findings: list[Finding] = field(default_factory=list)

    def find(self, path: KeyPath, message: str, remedy: str, *, at_key: bool = False) -> None:
        """Note a mistake."""
        self.findings.append(Finding(path, message, remedy, at_key))

    def known(self, path: KeyPath) -> KeyPath:
        """Longest part of the path that the document has."""
        while path and path not in self.values:
            path = path[:-1]
        return path

    def enter(self, path: KeyPath, spot: Spot) -> bool:
        """Note a value's place. False, with a finding, for one that is nested too deep.

        Raises:
            ConfigError: there are more values than any configuration has.
        """
        self.values[path] = spot
        if len(self.values) > MAX_VALUES:
            message = f"there are more than {MAX_VALUES} values"
            raise ConfigError(
                [Problem(self.file, spot.line, spot.column, message, "use aliases (*) sparingly")]
            )
        if len(path) > MAX_DEPTH:
            self.find(path, f"nested more than {MAX_DEPTH} deep", "no key is nested so deep")
            return False
        return True

    def scalar(self, path: KeyPath, value: object) -> object:
        """Answer the value if a configuration can hold it, else None, with a finding."""
        match value:
            case None | bool():
                return value
            case str():
                if is_unicode(value) and NUL not in value:
                    return value
                message, remedy = "holds half of a surrogate pair", "write the character itself"
                if NUL in value:
                    message = "holds the character NUL, which no name and no path can have"
                    remedy = "leave it out"
            case int():
                if value in _INT64:
                    return value
                message, remedy = "is too large a number", "a whole number has at most 64 bits"
            case float():
                if math.isfinite(value):
                    return value
                message, remedy = f"{value} is not a number to compute with", "write a finite number"
            case _:
                message = f"an object of type {type(value).__name__} is no configuration value"
                remedy = "give text, a number, true, false, None, a mapping or a list"
        self.findings.append(Finding(path, message, remedy))
        return None

    def error(self, findings: Iterable[Finding]) -> ConfigError:
        """Make problems of findings, in file order; of several about one value, the first only."""
        first: dict[tuple[KeyPath, Spot | None], Finding] = {}
        for finding in findings:
            first.setdefault((finding.path, finding.spot), finding)
        order = {path: index for index, path in enumerate(self.values)}
        ordered = sorted(
            ((self._spot(f), order.get(self.known(f.path), 0), f) for f in first.values()),
            key=lambda placed: placed[:2],
        )
        return ConfigError(
            [
                Problem(self.file, at.line, at.column, _line(dotted(f.path) + f.message), _line(f.remedy))
                for at, _, f in ordered
            ]
        )

    def _spot(self, finding: Finding) -> Spot:
        if finding.spot is not None:
            return finding.spot
        path = self.known(finding.path)
        if finding.at_key or path != finding.path:
            return self.keys.get(path) or self.values.get(path, NOWHERE)
        return self.values.get(path, NOWHERE)


def document_from_mapping(data: Mapping[str, object], file: str) -> Document:
    """Make a document without places from plain Python data (as a test writes it)."""
    document = Document(file)
    document.value = _plain(document, (), data)
    return document


def _plain(document: Document, path: KeyPath, value: object) -> object:
    if not document.enter(path, NOWHERE):
        return None
    if isinstance(value, Mapping):
        result: dict[str, object] = {}
        for key, item in value.items():
            name = key if isinstance(key, str) and is_unicode(key) else ascii(key)[:60]
            here = (*path, name)
            if name != key:
                document.find(here, f"the key {name} is not text", "keys are names", at_key=True)
            document.keys[here] = NOWHERE
            result[name] = _plain(document, here, item)
        return result
    if isinstance(value, list | tuple):
        return [_plain(document, (*path, index), item) for index, item in enumerate(value)]
    return document.scalar(path, str(value) if isinstance(value, PurePath) else value)


def is_unicode(text: str) -> bool:
    """True if a text is Unicode; one with a lone surrogate can be neither stored nor printed."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _line(text: str) -> str:
    return " ".join(text.split())


def dotted(path: KeyPath) -> str:
    """Format a key path as the beginning of a message."""
    parts = [str(part) if re.fullmatch(r"[\w-]{1,64}", str(part)) else repr(part)[:60] for part in path]
    return ".".join(parts) + ": " if parts else ""
