"""Things that a test gives: a configuration, bytes for ports and names. A slip is told in a sentence."""

import json
import math
import os
import reprlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from hil.config import ConfigError
from hil.vocab.near_words import meant
from hil.vocab.problem import Problem
from hil.vocab.typed_numbers import typed_number

GivenConfig = str | os.PathLike[str] | Mapping[str, Any]
"""A path, YAML text or a dict. A string is text if it is empty, or has a colon or the end of a line."""


def path_of(config: object) -> Path | None:
    """Path that a configuration was given as; None: it was given as text or as a dict.

    Raises:
        TypeError: it is none of them.
    """
    __tracebackhide__ = True
    if isinstance(config, os.PathLike):
        return Path(config)
    if isinstance(config, str):
        return None if not config or "\n" in config or ":" in config else Path(config)
    if isinstance(config, Mapping):
        return None
    raise TypeError(f"a bench is made from a path, YAML text or a dict, not from {reprlib.repr(config)}")


def unreadable(path: Path, error: OSError | ValueError) -> ConfigError:
    """Error of a configuration's file that cannot be read, with the path that was looked at."""
    why = error.strerror if isinstance(error, OSError) else error
    return ConfigError([Problem(str(path), 0, 0, str(why), f"it was looked for at {path.absolute()}")])


def as_json(config: Mapping[str, Any]) -> str:
    """Write a dict for a daemon to read; paths in it are text.

    Raises:
        TypeError: it has something in it that no configuration has.
    """
    __tracebackhide__ = True
    return json.dumps(config, default=_plain)  # YAML has JSON in it


def _plain(value: object) -> object:
    __tracebackhide__ = True
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"an object of type {type(value).__name__} is no configuration value")


def checked_bytes(data: bytes) -> bytes:
    """Copy what is to be written to a port, or is waited for at one.

    Raises:
        TypeError: it is text or a number, with what to give instead.
    """
    __tracebackhide__ = True
    if isinstance(data, (bytes, bytearray, memoryview)):
        return bytes(data)
    instead = repr(data.encode()) if isinstance(data, str) else "b'...'"
    raise TypeError(f"a port carries bytes: {instead}, not {data!r}")


def checked_ms(call: str, ms: float) -> float:
    """Check a time in milliseconds that a test gives. ``call``: the method that it gives it to.

    Raises:
        TypeError: it is no number, with what to give instead.
        ValueError: it is negative, or no number to compute with.
    """
    __tracebackhide__ = True
    try:
        is_from_0 = ms >= 0
    except TypeError:
        what = f"{ms!r} is text" if isinstance(ms, str) else f"{reprlib.repr(ms)} is no number"
        number = typed_number(ms) if isinstance(ms, str) else ""
        remedy = f"give a number of milliseconds, as {100 if isinstance(number, str) else number}"
        raise TypeError(f"{call}(ms=...): {what}; {remedy}") from None
    if not is_from_0 or math.isinf(ms):
        raise ValueError(f"{call}(ms=...): {ms:g} is no time from now on; give 0 or more")
    return ms


Thing = TypeVar("Thing")


class NoSuchName(KeyError):
    """Error of a name that is not there: ``str(error)`` is a sentence."""

    def __str__(self) -> str:
        return str(self.args[0])


def no_such(what: str, name: object, known: Mapping[str, object]) -> NoSuchName:
    """Error of a name that is not among those known; ``what``: the kind of thing, as in ``device``."""
    return NoSuchName(f"there is no {what} {name!r}; {meant(str(name), known)}")


class NamedThings(Mapping[str, Thing]):
    """Mapping that refuses a wrong name by a sentence."""

    def __init__(self, what: str, things: Mapping[str, Thing]) -> None:
        self._what = what
        self._things = things

    def __getitem__(self, name: str) -> Thing:
        __tracebackhide__ = True
        try:
            return self._things[name]
        except KeyError:
            raise no_such(self._what, name, self._things) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._things)

    def __len__(self) -> int:
        return len(self._things)
