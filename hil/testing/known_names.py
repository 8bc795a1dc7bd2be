"""Names that a face of the test kit does not have: a slip is told with what to write."""

from typing import TYPE_CHECKING, Any

from hil.vocab.near_words import meant


class KnownNames:
    """Base of faces whose wrong names are told with those that there are. ``_what``: what the face is."""

    _what = "it"

    def _instead_of(self, name: str) -> str:
        """Remedy for a name of another thing; empty: nothing is known."""
        return ""

    def _no_such(self, name: str) -> AttributeError:
        names = [each for each in dir(type(self)) if not each.startswith("_")]
        remedy = self._instead_of(name) or meant(name, names)
        return AttributeError(f"{self._what} has no {name!r}; {remedy}", name=name, obj=self)

    if not TYPE_CHECKING:  # a type checker knows which names there are

        def __getattr__(self, name: str) -> Any:
            __tracebackhide__ = True
            if name.startswith("_"):
                raise AttributeError(name)
            raise self._no_such(name)


class FixedNames(KnownNames):
    """Face at which nothing else can be set, either: a mistyped name would do nothing."""

    def __setattr__(self, name: str, value: object) -> None:
        __tracebackhide__ = True
        if not name.startswith("_") and not hasattr(type(self), name):
            raise self._no_such(name)
        super().__setattr__(name, value)


class Uncalled(KnownNames):
    """Fixture that makes benches, in place of which a bench is used. ``make``: its function."""

    def __init__(self, fixture: str, make: Any) -> None:
        self._fixture, self._make = fixture, make
        self._what = f"the fixture `{fixture}` makes benches, and"

    def _instead_of(self, name: str) -> str:
        return f'make one first, as in b = {self._fixture}("bench.yaml"), then write b.{name}'

    def __call__(self, *given: Any, **options: Any) -> Any:
        __tracebackhide__ = True
        return self._make(*given, **options)
