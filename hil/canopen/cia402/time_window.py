"""Window around a value, with a time that has to pass in it or outside of it."""

from hil.vocab.time import FOREVER


class TimeWindow:
    """Condition that counts once it has held for a time."""

    def __init__(self) -> None:
        self._since_ns: int | None = None

    def holds(self, is_so: bool, for_ns: int, now_ns: int) -> bool:
        """Take in whether it is so now; answers True if it has been for so long."""
        if not is_so:
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = now_ns
        return now_ns - self._since_ns >= for_ns

    def assume(self) -> None:
        """Take it that it has been so forever."""
        self._since_ns = -FOREVER

    def clear(self) -> None:
        """Begin again."""
        self._since_ns = None
