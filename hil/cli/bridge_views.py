"""Bridges as commands show them."""

from collections.abc import Mapping
from typing import Any


def reached_at(status: Mapping[str, Any]) -> str:
    """Say what a bridge has and where it is reached; once, where the former is a URL. ``status``: its own."""
    root, doors = str(status["root"]), [*status["listen"], *status["connect"]]
    return root if len(doors) == 1 and doors[0] in root else f"{root} at {', '.join(doors)}"
