"""Things by name whose ``KeyError`` is a sentence: what there is not, what is like it, and what there is."""

from collections.abc import Iterator, Mapping
from typing import TypeVar

from hil.vocab.near_words import meant

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
