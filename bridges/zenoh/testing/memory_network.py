"""Network of zenoh sessions in memory: what one says comes to the others, a little later, in order."""

from collections.abc import Callable
from typing import Any

import zenoh

from bridges.zenoh.testing.memory_messages import (
    Given,
    ItemReceiver,
    MemoryQuery,
    MemoryReply,
    MemoryReplyError,
    MemorySample,
    sample_of,
)
from hil.testing.doors.door_time import DoorTime

TIMEOUT_S = 10.0
"""Time-out of a query by default, as zenoh's."""


class Declared:
    """Subscriber, queryable or token of a session. ``is_remote``: True leaves the session's own out."""

    def __init__(
        self,
        kept: "list[Declared]",
        session: object,
        key_expr: zenoh.KeyExpr,
        received: ItemReceiver,
        is_remote: bool = False,
        gone: Callable[[], object] = lambda: None,
    ) -> None:
        self._kept, self._gone = kept, gone
        self.session, self.key_expr, self.is_remote = session, key_expr, is_remote
        self._received = received
        self.is_over = False
        kept.append(self)

    @property
    def handler(self) -> Any:
        """Channel in which items come, or what the program has given for it."""
        return self._received.handler

    def hear(self, item: Any) -> None:
        """Hand on what has come."""
        if not self.is_over:
            self._received.put(item)

    def hears(self, session: object, key: zenoh.KeyExpr, is_remote: bool) -> bool:
        """True if what a session says under a key is for this one."""
        is_own = session is self.session
        return not (is_own and (is_remote or self.is_remote)) and bool(self.key_expr.intersects(key))

    def end(self) -> None:
        """Undeclare it, if it is declared."""
        if not self.is_over:
            self.is_over = True
            self._kept.remove(self)
            self._received.end()
            self._gone()

    def undeclare(self) -> None:
        """Undeclare it. Raises zenoh.ZError: it is so already."""
        self._check()
        self.end()

    def _check(self) -> None:
        if self.is_over:
            raise zenoh.ZError("Undeclared subscriber")

    def try_recv(self) -> Any:
        """As ``MemoryChannel.try_recv``."""
        self._check()
        return self.handler.try_recv()

    def recv(self) -> Any:
        """As ``MemoryChannel.recv``."""
        self._check()
        return self.handler.recv()

    def __iter__(self) -> Any:
        self._check()
        return iter(self.handler)

    def __enter__(self) -> "Declared":
        return self

    def __exit__(self, *_: object) -> None:
        self.end()


class MemoryQuestion:
    """Question that is out. ``is_latest``: of several replies under one key the last is kept, until all have
    come."""

    def __init__(self, time: DoorTime, received: ItemReceiver, is_latest: bool, timeout_s: float) -> None:
        self._time, self._received, self._is_latest = time, received, is_latest
        self._kept: dict[str, MemoryReply] = {}
        self._left = 0
        self._is_over = False
        self._timer = time.loop.call_later(timeout_s, self._time_out)

    def query(self, selector: zenoh.Selector, given: Given) -> MemoryQuery:
        """Make the query for one who answers it."""
        self._left += 1
        return MemoryQuery(
            selector,
            given,
            lambda reply: self._time.later(self._hear, reply),
            lambda: self._time.later(self.answered),
        )

    def _hear(self, reply: MemoryReply) -> None:
        if self._is_over:
            return
        if reply.ok and self._is_latest:
            self._kept[str(reply.ok.key_expr)] = reply
        else:
            self._received.put(reply)

    def answered(self) -> None:
        """Note that one has answered, or that there is none."""
        self._left -= 1
        if self._left <= 0:
            self._end()

    def _time_out(self) -> None:
        if not self._is_over:
            text = MemoryReplyError(zenoh.ZBytes("Timeout"), zenoh.Encoding.ZENOH_STRING)
            self._received.put(MemoryReply(err=text))
            self._end()

    def _end(self) -> None:
        if self._is_over:
            return
        self._is_over = True
        self._timer.cancel()
        for reply in self._kept.values():
            self._received.put(reply)
        self._received.end()


class MemoryNetwork:
    """Network of the sessions at a door."""

    def __init__(self, time: DoorTime) -> None:
        self.time = time
        self.subscribers: list[Declared] = []
        self.queryables: list[Declared] = []
        self.tokens: list[Declared] = []
        self.token_subscribers: list[Declared] = []

    def publish(self, session: object, sample: MemorySample, is_remote: bool) -> None:
        """Carry a sample to those who have subscribed, in the order in which they did."""
        for each in self.subscribers:
            if each.hears(session, sample.key_expr, is_remote):
                self.time.later(each.hear, sample)

    def ask(
        self, session: object, selector: zenoh.Selector, asked: MemoryQuestion, is_remote: bool, given: Given
    ) -> None:
        """Carry a question to those who answer."""
        found = [each for each in self.queryables if each.hears(session, selector.key_expr, is_remote)]
        for each in found:
            self.time.later(each.hear, asked.query(selector, given))
        if not found:
            self.time.later(asked.answered)

    def tell_token(self, token: zenoh.KeyExpr, kind: zenoh.SampleKind) -> None:
        """Tell those who look for it that a token has come or gone."""
        for each in self.token_subscribers:
            if each.key_expr.intersects(token):
                self.time.later(each.hear, sample_of(token, b"", kind=kind))
