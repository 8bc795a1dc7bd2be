"""Smallest set of faults with which something still fails."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

Fault = TypeVar("Fault")
MOST_TRIES = 64
"""Maximum number of runs in search of one smallest set. Of 16 faults one is found in about 10, two in 30."""


class Smallest(NamedTuple):
    """Outcome of a search. ``faults``: empty if it fails without any."""

    faults: tuple[object, ...]
    is_proved: bool
    """True if it passes when any one of them is left out; False: the search was broken off."""
    tries: int


def find_smallest(
    faults: Sequence[Fault],
    fails: Callable[[Sequence[Fault]], bool],
    guesses: Sequence[Sequence[Fault]] = (),
) -> Smallest:
    """Search for a set from which no fault can be left out (delta debugging, Zeller and Hildebrandt 2002).
    ``fails``: carries out a run with some of them; with all of them it does. ``guesses``: sets that were
    found before, at other seeds."""
    tries = 0

    def still_fails(some: Sequence[Fault]) -> bool:
        nonlocal tries
        tries += 1
        return fails(some)

    if still_fails(()):
        return Smallest((), True, tries)
    kept = list(faults)
    for guess in guesses:
        if guess and set(guess) < set(kept) and still_fails(guess):
            kept = [each for each in kept if each in set(guess)]
            break
    pieces = 2
    while len(kept) > 1 and tries < MOST_TRIES:
        size = -(-len(kept) // pieces)
        for start in range(0, len(kept), size):
            rest = kept[:start] + kept[start + size :]
            if rest and tries < MOST_TRIES and still_fails(rest):
                kept, pieces = rest, max(pieces - 1, 2)
                break
        else:
            if size == 1:
                return Smallest(tuple(kept), tries < MOST_TRIES, tries)
            pieces = min(2 * pieces, len(kept))
    return Smallest(tuple(kept), len(kept) <= 1, tries)
