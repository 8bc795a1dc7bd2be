"""Nearest of known words to one that is mistyped."""

import difflib
from collections.abc import Collection, Iterable


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Known word that the given one is most likely a slip of, if any; - and _ are alike, as are cases."""
    by_lower = {_plain(name): name for name in known}
    close = difflib.get_close_matches(_plain(word), by_lower, n=1, cutoff=0.6)
    return by_lower[close[0]] if close else None


def nearest_or_begun(word: str, known: Collection[str]) -> list[str]:
    """The nearest known word, and those that the given one is the beginning of."""
    near = nearest(word, known)
    begun = (name for name in known if _plain(name).startswith(_plain(word)))
    return list(dict.fromkeys([*([near] if near else []), *begun]))


def did_you_mean(*words: str | None) -> str:
    """``did you mean "a" or "b"?``; empty if none is given."""
    quoted = [f'"{word}"' for word in words if word]
    return f"did you mean {' or '.join(quoted)}?" if quoted else ""


def meant(word: str, known: Collection[str], there: str = "") -> str:
    """``did you mean "a"?`` if one is near, then ``there``: by default all that there are, in their order."""
    all_known = f"there are {', '.join(known) or 'none'}"
    return " ".join(filter(None, [did_you_mean(nearest(word, known)), there or all_known]))


def _plain(word: str) -> str:
    return word.lower().replace("-", "_")
