"""Sender of answers to queries, in a thread of its own: zenoh keeps who answers waiting for a client that
does not read, and that must not be the event loop."""

import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

import zenoh

log = logging.getLogger("hil")

WAITING = 20_000
"""Maximum number of answers that wait; later ones are dropped and counted, and their askers time out."""
END_S = 2.0


class Sender:
    """Sends replies in the order in which they were given."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[tuple[zenoh.Query, str | None, bytes | None, Any] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="zenoh-replies", daemon=True)
        self._thread.start()
        self.dropped = 0

    @property
    def waiting(self) -> int:
        """Number of answers that have not gone out."""
        return self._queue.qsize()

    def end(self, query: zenoh.Query) -> None:
        """End a query after its last answer; else the asker waits for its time-out."""
        self._queue.put((query, None, None, None))

    def reply(self, query: zenoh.Query, key: str | None, content: bytes, encoding: zenoh.Encoding) -> None:
        """Reply to a query; without a key it is a refusal."""
        if self._queue.qsize() >= WAITING:
            self.dropped += 1
        else:
            self._queue.put((query, key, content, encoding))

    def _run(self) -> None:
        while (answer := self._queue.get()) is not None:
            with suppress(zenoh.ZError):  # the asker has gone
                _send(*answer)

    def close(self) -> None:
        """Drop what waits; answers that zenoh holds up are left to it."""
        while True:
            try:
                self._queue.get_nowait()
            except Empty:
                break
        self._queue.put(None)
        self._thread.join(END_S)


class DirectSender(Sender):
    """Sender without a thread, for askers that never hold it up."""

    def __init__(self) -> None:
        self.dropped = 0

    @property
    def waiting(self) -> int:
        return 0

    def end(self, query: zenoh.Query) -> None:
        _send(query, None, None, None)

    def reply(self, query: zenoh.Query, key: str | None, content: bytes, encoding: zenoh.Encoding) -> None:
        _send(query, key, content, encoding)

    def close(self) -> None:
        """Nothing waits."""


def _send(query: Any, key: str | None, content: bytes | None, encoding: Any) -> None:
    """Send an answer; without a content the query ends."""
    if content is None:
        query.drop()
    elif key is None:
        query.reply_err(content, encoding=encoding)
    else:
        query.reply(key, content, encoding=encoding)


class Senders:
    """Senders of what is told to commands and of answers to readings. Each has its thread: an acknowledgement
    waits for no reading."""

    def __init__(self, made: Callable[[], Sender] = Sender) -> None:
        self.acks, self.answers = made(), made()

    @property
    def dropped(self) -> int:
        return self.acks.dropped + self.answers.dropped

    def close(self) -> None:
        self.acks.close()
        self.answers.close()
