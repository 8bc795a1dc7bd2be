"""Sessions of users that have logged in, and the limit on attempts. Time is given by the caller. Pure."""

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from hil.vocab.desk_protocol import Source

LIFE_S = 12 * 3600.0
"""Time after its last use for which a session lives: a day's work. A page that is open uses it."""
MOST_SESSIONS = 512
ATTEMPTS = 5
"""Attempts to log in that an address has at once."""
AGAIN_S = 12.0
"""Time after which it has one more."""
MOST_ADDRESSES = 1024


@dataclass
class _Session:
    source: Source
    used_s: float
    pages: int = 0
    """Number of pages that are open."""


class Sessions:
    """Sessions by their key, which only the browser has; here is its digest."""

    def __init__(self) -> None:
        self._known: OrderedDict[bytes, _Session] = OrderedDict()

    def begin(self, key: str, source: Source, now_s: float) -> None:
        """Begin a session. Where there are too many, the one that was not used for longest ends."""
        self._known[_digest(key)] = _Session(source, now_s)
        if len(self._known) > MOST_SESSIONS:
            self._known.popitem(last=False)

    def find(self, key: str, now_s: float) -> Source | None:
        """User of a session, which has been used now; None: there is none."""
        digest = _digest(key)
        if (session := self._known.get(digest)) is None:
            return None
        if not session.pages and now_s - session.used_s > LIFE_S:
            del self._known[digest]
            return None
        session.used_s = now_s
        self._known.move_to_end(digest)
        return session.source

    @contextmanager
    def in_use(self, key: str, now_s: Callable[[], float]) -> Iterator[None]:
        """Hold a session, if there is one, while a page is open: it lives on, and for its time after it."""
        session = self._known.get(_digest(key))
        if session is None:
            yield
            return
        session.pages += 1
        try:
            yield
        finally:
            session.pages -= 1
            session.used_s = now_s()

    def end(self, key: str) -> None:
        """End a session, if there is one."""
        self._known.pop(_digest(key), None)


def _digest(key: str) -> bytes:
    return hashlib.sha256(key.encode("utf-8", "surrogatepass")).digest()


class LoginLimit:
    """Limit on attempts to log in, for each address: ``ATTEMPTS`` at once, then one each ``AGAIN_S``."""

    def __init__(self) -> None:
        self._full_at_s: OrderedDict[str, float] = OrderedDict()
        """Time at which an address has all its attempts again."""

    def wait_s(self, address: str, now_s: float) -> float:
        """Count an attempt, and answer 0; or answer how long to wait for one, which is not counted."""
        full_at_s = max(self._full_at_s.get(address, now_s), now_s)
        over_s = full_at_s + AGAIN_S - now_s - ATTEMPTS * AGAIN_S
        if over_s > 0:
            return over_s
        self._full_at_s[address] = full_at_s + AGAIN_S
        self._full_at_s.move_to_end(address)
        if len(self._full_at_s) > MOST_ADDRESSES:
            self._full_at_s.popitem(last=False)
        return 0.0

    def succeeded(self, address: str) -> None:
        """Give an attempt back: it was right. Many users may come from one address."""
        if address in self._full_at_s:
            self._full_at_s[address] -= AGAIN_S
