"""Labels of a bench: the words of its configuration, and the words by which benches are chosen."""

import re
from collections.abc import Mapping

LABEL_CHARACTERS = 63
_VALUE = re.compile(rf"[A-Za-z0-9][A-Za-z0-9._/:-]{{0,{LABEL_CHARACTERS - 1}}}")


def is_label_value(text: str) -> bool:
    """True if a text can be the value of a label."""
    return _VALUE.fullmatch(text) is not None


def wanted_label(text: str) -> tuple[str, str]:
    """Read `rig=press` as a name and a value.

    Raises:
        ValueError: it is none.
    """
    name, equals, value = text.partition("=")
    if not (name and equals and is_label_value(value)):
        raise ValueError(f"{text!r} is no label; write NAME=VALUE, as in rig=press")
    return name, value


def has_labels(labels: Mapping[str, str], wanted: Mapping[str, str]) -> bool:
    """True if a bench with these labels has all that are wanted."""
    return all(labels.get(name) == value for name, value in wanted.items())
