"""A board's non-volatile memory, and what is being written to it."""

from collections import deque
from collections.abc import Callable, Mapping

from hil.vocab.firmware import Commit


class Memory:
    """``store`` makes sections the whole memory, and answers whether they are durable, or None: ``answered``
    will be called."""

    def __init__(
        self, content: Mapping[str, bytes], store: Callable[[Mapping[str, bytes]], bool | None]
    ) -> None:
        self.content = dict(content)
        """By the names of sections; what was asked for and is not durable yet is not in it."""
        self._store = store
        self._pending: deque[dict[str, bytes]] = deque()
        """The whole memory of each commit that the store has not answered, in their order."""

    @property
    def is_committing(self) -> bool:
        """The store has not answered yet."""
        return bool(self._pending)

    def commit(self, request: Commit) -> bool | None:
        """Begin to write; ``store``'s answer."""
        whole = self.content | {request.name: request.data}
        self._pending.append(whole)
        return self._store(whole)

    def answered(self, durable: bool) -> bool:
        """The store has answered the oldest commit; one that failed leaves the old content. Returns whether
        there was one."""
        if not self._pending:
            return False
        whole = self._pending.popleft()
        if durable:
            self.content.update(whole)
        return True
