"""Samples, queries and replies in memory, with the attributes of zenoh's, which only zenoh can make."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, Self, TypeVar

import zenoh

from hil.testing.doors.door_time import TRIP_NS, DoorTime
from hil.vocab.time import FOREVER

Item = TypeVar("Item")
_CLOSED = "channel is empty and closed"


@dataclass(frozen=True)
class MemorySample:
    """Sample of a key, with the attributes of zenoh's ``Sample``."""

    key_expr: zenoh.KeyExpr
    payload: zenoh.ZBytes
    encoding: zenoh.Encoding
    kind: zenoh.SampleKind
    attachment: zenoh.ZBytes | None
    congestion_control: zenoh.CongestionControl
    priority: zenoh.Priority
    express: bool
    timestamp: None = None


@dataclass(frozen=True)
class MemoryReplyError:
    """Refusal of a query, with the attributes of zenoh's ``ReplyError``."""

    payload: zenoh.ZBytes
    encoding: zenoh.Encoding


@dataclass(frozen=True)
class MemoryReply:
    """Reply to a query, with the attributes of zenoh's ``Reply``: ``ok`` or ``err``."""

    ok: MemorySample | None = None
    err: MemoryReplyError | None = None

    @property
    def result(self) -> MemorySample | MemoryReplyError | None:
        return self.ok or self.err


class Given(NamedTuple):
    """Content of a question."""

    payload: zenoh.ZBytes | None
    encoding: zenoh.Encoding
    attachment: zenoh.ZBytes | None


class MemoryQuery:
    """Query as one who answers it has it. ``hear``: called with each reply, ``end``: after the last."""

    def __init__(
        self,
        selector: zenoh.Selector,
        given: Given,
        hear: Callable[[MemoryReply], object],
        end: Callable[[], object],
    ) -> None:
        self.selector, self.key_expr, self.parameters = selector, selector.key_expr, selector.parameters
        self.payload, self.encoding, self.attachment = given
        self._hear, self._end = hear, end
        self._is_over = False

    def reply(self, key: Any, payload: Any, *, encoding: Any = None, attachment: Any = None) -> None:
        """Answer."""
        self._hear(MemoryReply(ok=sample_of(key, payload, encoding=encoding, attachment=attachment)))

    def reply_err(self, payload: Any, *, encoding: Any = None) -> None:
        """Refuse."""
        self._hear(MemoryReply(err=MemoryReplyError(_zbytes(payload), encoding_of(encoding))))

    def drop(self) -> None:
        """Say that nothing more comes."""
        if not self._is_over:
            self._is_over = True
            self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.drop()


def key_of(given: Any) -> zenoh.KeyExpr:
    """Key expression as it is given. Raises TypeError, zenoh.ZError: it is none."""
    return given if isinstance(given, zenoh.KeyExpr) else zenoh.KeyExpr(given)


def _zbytes(given: Any) -> zenoh.ZBytes:
    return given if isinstance(given, zenoh.ZBytes) else zenoh.ZBytes(given)


def encoding_of(given: Any) -> zenoh.Encoding:
    """Encoding as it is given; bytes by default."""
    if given is None:
        return zenoh.Encoding.ZENOH_BYTES
    return given if isinstance(given, zenoh.Encoding) else zenoh.Encoding(given)


def bytes_of(given: Any) -> zenoh.ZBytes | None:
    """Payload or attachment; None: there is none."""
    return None if given is None else _zbytes(given)


def sample_of(
    key: Any,
    payload: Any,
    *,
    encoding: Any = None,
    attachment: Any = None,
    kind: zenoh.SampleKind = zenoh.SampleKind.PUT,
    congestion_control: Any = None,
    priority: Any = None,
    express: bool | None = None,
) -> MemorySample:
    """Make a sample of what a program gives. Raises TypeError, zenoh.ZError: as zenoh does."""
    return MemorySample(
        key_of(key),
        _zbytes(payload),
        encoding_of(encoding),
        kind,
        bytes_of(attachment),
        congestion_control or zenoh.CongestionControl.DROP,
        priority or zenoh.Priority.DATA,
        bool(express),
    )


class MemoryChannel(Generic[Item]):
    """Channel in which items come, as zenoh's ``Handler``: waiting lets simulated time pass. It has room for
    all. ``what``: what is waited for, for people."""

    def __init__(self, time: DoorTime, what: str) -> None:
        self._time, self._what = time, what
        self._items: deque[Item] = deque()
        self._is_over = False

    def put(self, item: Item) -> None:
        self._items.append(item)

    def end(self) -> None:
        """Let nothing more come."""
        self._is_over = True

    def _has_come(self) -> bool:
        return bool(self._items) or self._is_over

    def _next(self) -> Item:
        if not self._items:
            raise zenoh.ZError(_CLOSED)
        return self._items.popleft()

    def try_recv(self) -> Item | None:
        """Take the next item, None if there is none: looking then takes 50 us, so that a loop ends. Raises
        zenoh.ZError: nothing comes any more."""
        come = self._time.wait(self._has_come, self._time.now_ns() + TRIP_NS, self._what)
        return self._next() if come else None

    def recv(self) -> Item:
        """Wait for the next item. Raises zenoh.ZError: nothing comes any more; NothingComes: nothing has come
        for an hour."""
        self._time.wait(self._has_come, FOREVER, self._what)
        return self._next()

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Item:
        self._time.wait(self._has_come, FOREVER, self._what)
        if not self._items:
            raise StopIteration
        return self._items.popleft()


class ItemReceiver(NamedTuple):
    """Receiver of items: ``put`` is called with each, ``end`` after the last; ``handler`` is what the program
    has of it."""

    put: Callable[[Any], object]
    end: Callable[[], object]
    handler: Any


def receiver(given: Any, time: DoorTime, what: str) -> ItemReceiver:
    """Make the receiver that a program asks for, as zenoh's handlers are given. Raises TypeError: there is no
    such handler here."""
    handlers = zenoh.handlers
    if given is None or isinstance(given, (handlers.DefaultHandler, handlers.FifoChannel)):
        channel: MemoryChannel[Any] = MemoryChannel(time, what)
        return ItemReceiver(channel.put, channel.end, channel)
    callback, handler = given if isinstance(given, tuple) and len(given) == 2 else (given, None)
    if isinstance(callback, handlers.RingChannel) or not callable(callback):
        raise TypeError("handler: give a function, a pair of a function and a handler, or nothing")
    return ItemReceiver(callback, getattr(callback, "drop", None) or (lambda: None), handler)
