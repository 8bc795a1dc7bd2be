"""Dataclasses that are made when they are first used: a command needs few of the hundred that it imports, and
each takes half a millisecond to be made."""

import dataclasses
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(made=None, /, **options):
        """Make a dataclass of a class, as that of the standard library: at once, or after ``make_later`` with
        its first instance or the first look at its fields."""
        if made is None:
            return lambda made: dataclass(made, **options)
        can_wait = _waits and "__init__" not in vars(made) and "slots" not in options
        return _Later(made, options).stub() if can_wait else dataclasses.dataclass(made, **options)


__all__ = ["dataclass", "make_later"]
_waits: list[bool] = []


def make_later() -> None:
    """Let the dataclasses of modules that are imported from now on be made when they are first used. For
    programs in which one thread does that."""
    _waits[:] = [True]


class _Later:
    """Fields of a class that is not a dataclass yet."""

    def __init__(self, made: Any, options: dict[str, Any]) -> None:
        self._made, self._options = made, options

    def __get__(self, instance: object, owner: Any) -> Any:
        self._make()
        return owner.__dataclass_fields__

    def stub(self) -> Any:
        """Answer the class, which makes itself a dataclass."""

        def init(this: Any, *given: Any, **named: Any) -> None:
            self._make()
            self._made.__init__(this, *given, **named)

        self._made.__init__, self._made.__dataclass_fields__ = init, self
        return self._made

    def _make(self) -> None:
        if vars(self._made).get("__dataclass_fields__") is self:
            del self._made.__init__, self._made.__dataclass_fields__
            dataclasses.dataclass(self._made, **self._options)
