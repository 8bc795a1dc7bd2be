"""Items of a capture in the order of their times.

They come in the order in which they are complete: a line of bytes that began first may end last, and of
several sources each has its own delay.
"""

import heapq
from array import array
from collections.abc import Callable, Iterable, Iterator

from hil.compose.decoded_item import DecodedItem
from hil.wire.pcapng import CaptureError

_EARLIEST_NS, _LATEST_NS = -(1 << 63), (1 << 63) - 1
"""Years 1677 and 2262. A file may say times beyond, which have no order among them then."""
WINDOW_NS = 500_000_000
"""Time by which items are held back live: longer than nearly all of them take."""


class ReorderWindow:
    """Order of items as they come: each is held until one is there that is later by ``window_ns``. What is
    later complete than that comes at once, behind later ones."""

    def __init__(self, window_ns: int = WINDOW_NS) -> None:
        self._window_ns = window_ns
        self._held: list[tuple[int, int, DecodedItem]] = []
        self._count = 0
        self._latest_ns = 0

    def put(self, items: Iterable[DecodedItem]) -> Iterator[DecodedItem]:
        """Put items; answers those that need not wait longer."""
        for item in items:
            heapq.heappush(self._held, (item.at_ns, self._count, item))
            self._count += 1
            self._latest_ns = max(self._latest_ns, item.at_ns)
        while self._held and self._held[0][0] <= self._latest_ns - self._window_ns:
            yield heapq.heappop(self._held)[2]

    def rest(self) -> Iterator[DecodedItem]:
        """Give all that is held: nothing comes for a while, or any more."""
        while self._held:
            yield heapq.heappop(self._held)[2]


def in_window(items: Iterable[DecodedItem | None]) -> Iterator[DecodedItem]:
    """Order items as they come; None: nothing comes for a while.

    Raises:
        CaptureError: after all items, where they end with it.
    """
    window = ReorderWindow()
    error: CaptureError | None = None
    try:
        for item in items:
            yield from window.rest() if item is None else window.put([item])
    except CaptureError as caught:
        error = caught
    yield from window.rest()
    if error:
        raise error


def in_order(again: Callable[[], Iterable[DecodedItem]]) -> Iterator[DecodedItem]:
    """Sort items that can be had twice: the first time for their times alone, 8 bytes each, the second time
    for what they say. Only those that are out of order are held.

    Raises:
        CaptureError: after all items, where they end with it.
    """
    next_ns, error = array("q"), None
    try:
        next_ns.extend(max(_EARLIEST_NS, min(item.at_ns, _LATEST_NS)) for item in again())
    except CaptureError as caught:
        error = caught
    for at in range(len(next_ns) - 2, -1, -1):  # the earliest time of each item and all behind it
        next_ns[at] = min(next_ns[at], next_ns[at + 1])
    held: list[tuple[int, int, DecodedItem]] = []
    for at, item in zip(range(len(next_ns)), again(), strict=False):
        heapq.heappush(held, (item.at_ns, at, item))
        while held and (at + 1 == len(next_ns) or held[0][0] <= next_ns[at + 1]):
            yield heapq.heappop(held)[2]
    if error:
        raise error
