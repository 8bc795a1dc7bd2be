"""Nearest of known words to one that is mistyped."""

import difflib
from collections.abc import Collection, Iterable

MOST = 5
"""Words that are asked for at once."""
_SHORT = 2
"""Length of a part of a word that says little."""


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Known word that the given one is most likely a slip of, if any; - and _ are alike, as are cases."""
    by_lower = {_plain(name): name for name in known}
    close = difflib.get_close_matches(_plain(word), by_lower, n=1, cutoff=0.6)
    return by_lower[close[0]] if close else None


def nearest_or_begun(word: str, known: Collection[str]) -> list[str]:
    """Known words that may be meant, at most ``MOST``: those that the given one is the beginning of, else the
    nearest, else those that it is a part of."""
    plain = _plain(word)
    if same := [name for name in known if _plain(name) == plain]:
        return same
    if begun := [name for name in known if _plain(name).startswith(plain)][: MOST if len(plain) > 1 else 0]:
        return begun
    if near := nearest(word, known):
        return [near]
    return [name for name in known if plain in _plain(name)][: MOST if len(plain) > _SHORT else 0]


def nearest_or_longer(word: str, known: Collection[str]) -> list[str]:
    """The same, but the nearest alone where no more than a letter is left out."""
    words, near = nearest_or_begun(word, known), nearest(word, known)
    return [near] if near in words and near and len(near) <= len(word) + 1 else words


def did_you_mean(*words: str | None) -> str:
    """``did you mean "a" or "b"?``; empty if none is given."""
    quoted = [f'"{word}"' for word in words if word]
    return f"did you mean {' or '.join(quoted)}?" if quoted else ""


def meant(word: str, known: Collection[str], there: str = "") -> str:
    """``did you mean "a" or "b"?`` if some may be meant, then ``there``: by default all that there are, in
    their order."""
    all_known = f"there are {', '.join(known) or 'none'}"
    return " ".join(filter(None, [did_you_mean(*nearest_or_longer(word, known)), there or all_known]))


def _plain(word: str) -> str:
    return word.lower().replace("-", "_")
