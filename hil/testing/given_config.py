"""Configurations that a test gives: a path, YAML text or a dict."""

import json
import os
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hil.config import ConfigError
from hil.vocab.problem import Problem

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
