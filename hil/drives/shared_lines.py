"""Lines and buses that the drives of a bench share."""

from typing import Any, TypeVar

Lines = TypeVar("Lines")


class SharedLines:
    """Lines of each kind of drive, made when the first of that kind begins."""

    def __init__(self) -> None:
        self._made: dict[type[Any], Any] = {}

    def of(self, kind: type[Lines]) -> Lines:
        """Give the one object of a class that has the lines of a kind."""
        if kind not in self._made:
            self._made[kind] = kind()
        made: Lines = self._made[kind]
        return made
