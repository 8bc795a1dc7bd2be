"""Session at a door in memory, with the calls of zenoh's ``Session``."""

from collections.abc import Callable
from typing import Any, Self

import zenoh

from bridges.zenoh.testing.memory_messages import (
    Given,
    ItemReceiver,
    MemoryReply,
    bytes_of,
    encoding_of,
    key_of,
    receiver,
    sample_of,
)
from bridges.zenoh.testing.memory_network import TIMEOUT_S, Declared, MemoryNetwork, MemoryQuestion

_REMOTE = zenoh.Locality.REMOTE
_NOBODY = ItemReceiver(lambda item: None, lambda: None, None)
_ONE_BY_ONE = (zenoh.ConsolidationMode.NONE, zenoh.ConsolidationMode.MONOTONIC)


class MatchingStatus:
    """Answer whether somebody hears a publisher."""

    def __init__(self, matching: bool) -> None:
        self.matching = matching

    def __bool__(self) -> bool:
        return self.matching


class MemoryPublisher:
    """Publisher of one key. ``options``: of zenoh's ``put``, for all samples."""

    def __init__(self, session: "MemorySession", key: zenoh.KeyExpr, is_remote: bool, **options: Any) -> None:
        self._session, self.key_expr, self._is_remote = session, key, is_remote
        self._options = options
        self._is_over = False

    @property
    def matching_status(self) -> MatchingStatus:
        """Status whether anybody has subscribed."""
        session, key = self._session, self.key_expr
        found = session.network.subscribers
        return MatchingStatus(any(each.hears(session, key, self._is_remote) for each in found))

    def put(self, payload: Any, **options: Any) -> None:
        """Publish a sample. Raises zenoh.ZError: it is undeclared."""
        if self._is_over:
            raise zenoh.ZError("Undeclared publisher")
        self._session.publish(self.key_expr, payload, self._is_remote, **(self._options | options))

    def undeclare(self) -> None:
        """End it."""
        self._is_over = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.undeclare()


class MemoryQuerier:
    """Questions under one key. ``options``: of zenoh's ``get``, for all of them."""

    def __init__(self, session: "MemorySession", key: zenoh.KeyExpr, options: dict[str, Any]) -> None:
        self._session, self.key_expr, self._options = session, key, options

    def get(self, handler: Any = None, *, parameters: Any = None, **options: Any) -> Any:
        """Ask."""
        selector = zenoh.Selector(self.key_expr, parameters)
        return self._session.get(selector, handler, **(self._options | options))

    def undeclare(self) -> None:
        """End it."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is open."""


class MemoryLiveliness:
    """Tokens, and looks at them."""

    def __init__(self, session: "MemorySession") -> None:
        self._session, self._network = session, session.network

    def declare_token(self, key_expr: Any) -> Declared:
        """Declare a token."""
        network, key = self._network, key_of(key_expr)
        made = self._session.declare(
            network.tokens, key, _NOBODY, gone=lambda: network.tell_token(key, zenoh.SampleKind.DELETE)
        )
        network.tell_token(key, zenoh.SampleKind.PUT)
        return made

    def get(self, key_expr: Any, handler: Any = None, *, timeout: float | None = None) -> Any:
        """Ask for the tokens that there are."""
        network, key = self._network, key_of(key_expr)
        self._session.check_open()
        received = receiver(handler, network.time, f"tokens of {key}")
        for token in network.tokens:
            if key.intersects(token.key_expr):
                network.time.later(received.put, MemoryReply(ok=sample_of(token.key_expr, b"")))
        network.time.later(received.end)
        return received.handler

    def declare_subscriber(self, key_expr: Any, handler: Any = None, *, history: bool = False) -> Declared:
        """Subscribe to tokens that come and go; ``history``: to those that are there, too."""
        network, key = self._network, key_of(key_expr)
        received = receiver(handler, network.time, f"tokens of {key}")
        made = self._session.declare(network.token_subscribers, key, received)
        for token in network.tokens if history else ():
            if key.intersects(token.key_expr):
                network.time.later(made.hear, sample_of(token.key_expr, b""))
        return made


class MemorySession:
    """Session. ``subscribing``: called with each key to which it subscribes."""

    def __init__(
        self, network: MemoryNetwork, subscribing: Callable[[zenoh.KeyExpr], object] = lambda key: None
    ) -> None:
        self.network, self._subscribing = network, subscribing
        self._declared: list[Declared] = []
        self._is_closed = False

    def check_open(self) -> None:
        """Check that it is open. Raises zenoh.ZError: it is not."""
        if self._is_closed:
            raise zenoh.ZError("session closed")

    def declare(
        self, kept: list[Declared], key: zenoh.KeyExpr, received: ItemReceiver, **options: Any
    ) -> Declared:
        """Declare an entity of this session."""
        self.check_open()
        made = Declared(kept, self, key, received, **options)
        self._declared.append(made)
        return made

    def publish(self, key: zenoh.KeyExpr, payload: Any, is_remote: bool, **options: Any) -> None:
        """Carry a sample to others, and to this session unless ``is_remote``."""
        self.check_open()
        self.network.publish(self, sample_of(key, payload, **options), is_remote)

    def put(self, key_expr: Any, payload: Any, *, allowed_destination: Any = None, **options: Any) -> None:
        """Put a sample under a key."""
        self.publish(key_of(key_expr), payload, allowed_destination == _REMOTE, **options)

    def get(
        self,
        selector: Any,
        handler: Any = None,
        *,
        payload: Any = None,
        encoding: Any = None,
        attachment: Any = None,
        consolidation: Any = None,
        timeout: float | None = None,
        target: Any = None,
        accept_replies: Any = None,
        priority: Any = None,
        congestion_control: Any = None,
        express: Any = None,
        allowed_destination: Any = None,
    ) -> Any:
        """Ask under a key or many; answers the channel of replies, in which simulated time passes."""
        self.check_open()
        asked_for = selector if isinstance(selector, zenoh.Selector) else zenoh.Selector(selector)
        given = Given(bytes_of(payload), encoding_of(encoding), bytes_of(attachment))
        received = receiver(handler, self.network.time, f"replies to {asked_for}")
        wanted_s = TIMEOUT_S if timeout is None else timeout
        asked = MemoryQuestion(self.network.time, received, consolidation not in _ONE_BY_ONE, wanted_s)
        self.network.ask(self, asked_for, asked, allowed_destination == _REMOTE, given)
        return received.handler

    def declare_subscriber(
        self, key_expr: Any, handler: Any = None, *, allowed_origin: Any = None
    ) -> Declared:
        """Subscribe to a key or many."""
        key = key_of(key_expr)
        self._subscribing(key)
        received = receiver(handler, self.network.time, f"a sample of {key}")
        return self.declare(self.network.subscribers, key, received, is_remote=allowed_origin == _REMOTE)

    def declare_queryable(
        self, key_expr: Any, handler: Any = None, *, complete: bool = False, allowed_origin: Any = None
    ) -> Declared:
        """Answer under a key or many."""
        key = key_of(key_expr)
        received = receiver(handler, self.network.time, f"a query of {key}")
        return self.declare(self.network.queryables, key, received, is_remote=allowed_origin == _REMOTE)

    def declare_publisher(
        self, key_expr: Any, *, allowed_destination: Any = None, reliability: Any = None, **options: Any
    ) -> MemoryPublisher:
        """Make a publisher of a key."""
        self.check_open()
        return MemoryPublisher(self, key_of(key_expr), allowed_destination == _REMOTE, **options)

    def declare_querier(self, key_expr: Any, **options: Any) -> MemoryQuerier:
        """Make a querier of a key."""
        self.check_open()
        return MemoryQuerier(self, key_of(key_expr), options)

    def liveliness(self) -> MemoryLiveliness:
        """Make looks at tokens."""
        return MemoryLiveliness(self)

    def undeclare(self, entity: Any) -> None:
        """Undeclare an entity."""
        entity.undeclare()

    def is_closed(self) -> bool:
        """True after ``close``."""
        return self._is_closed

    def close(self) -> None:
        """End all that it has declared."""
        if not self._is_closed:
            self._is_closed = True
            for each in reversed(self._declared):
                each.end()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
