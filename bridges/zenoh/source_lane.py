"""Queue in which askers take turns: one who asks a lot has the longest wait himself."""

from collections import deque
from typing import Generic, TypeVar

Item = TypeVar("Item")


class SourceLane(Generic[Item]):
    """Queue of ``room`` items, of which each source has at most half."""

    def __init__(self, room: int) -> None:
        self.room = room
        self._waiting: dict[str, deque[Item]] = {}
        """Items by source; the source whose turn is next comes first."""
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def put(self, source: str, item: Item) -> bool:
        """Queue an item. False: there is no room."""
        own = self._waiting.get(source)
        if self._count >= self.room or (own is not None and 2 * len(own) >= self.room):
            return False
        if own is None:
            own = self._waiting[source] = deque()
        own.append(item)
        self._count += 1
        return True

    def take(self) -> Item:
        """Take the next item of the source whose turn it is. Raises StopIteration: there is none."""
        source = next(iter(self._waiting))
        own = self._waiting.pop(source)
        self._count -= 1
        item = own.popleft()
        if own:
            self._waiting[source] = own  # behind the others
        return item

    def clear(self) -> None:
        self._waiting.clear()
        self._count = 0
