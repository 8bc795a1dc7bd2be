"""Nearest of known words to one that is mistyped."""

import difflib
from collections.abc import Collection, Iterable


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Known word that the given one is most likely a slip of, if any; - and _ are alike, as are cases."""
    by_lower = {_plain(name): name for name in known}
    close = difflib.get_close_matches(_plain(word), by_lower, n=1, cutoff=0.6)
    return by_lower[close[0]] if close else None


def meant(word: str, known: Collection[str]) -> str:
    """``did you mean x?`` if one is near, and all that there are, in their order."""
    near = nearest(word, known)
    return (f"did you mean {near}? " if near else "") + f"there are {', '.join(known) or 'none'}"


def _plain(word: str) -> str:
    return word.lower().replace("-", "_")
