"""Bench of a live lab that a program has for as long as it needs it: a lease that is renewed meanwhile."""

import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from hil.client.messages import ClientError, CommandError
from hil.client.synchronous import Bench

HELD_S = 120.0
"""Length of such a lease. A program that is killed leaves the bench free after so long."""
_RENEWALS = 4
"""Number of times that it is renewed within its length: three may be lost."""


class _Renewal(threading.Thread):
    """Thread that renews a lease until ``end``. ``why_lost``: why it is another's, or nobody's; empty while
    it holds."""

    def __init__(self, bench: Bench, held_s: float) -> None:
        super().__init__(name=f"lease of {bench.name}", daemon=True)
        self._bench, self._held_s = bench, held_s
        self._is_over = threading.Event()
        self.why_lost = ""

    def run(self) -> None:
        while not self._is_over.wait(self._held_s / _RENEWALS):
            try:
                self._bench.renew_lease(for_s=self._held_s)
            except CommandError as error:
                self.why_lost = str(error)
                return
            except ClientError:
                continue  # the link is away; the next one may come through

    def end(self) -> None:
        self._is_over.set()
        self.join()


@contextmanager
def held(bench: Bench, why: str, *, doors: Sequence[str] = (), held_s: float = HELD_S) -> Iterator[Bench]:
    """Have a bench within a block. Its lease is renewed, and given back at the end, also after an error.
    ``held_s``: maximum time after which a bench is free whose program was killed.

    Raises:
        CommandError: somebody has it, or the bench does not know who asks.
        ClientError: nobody answers.
    """
    bench.lease(why, for_s=held_s, doors=doors)
    renewal = _Renewal(bench, held_s)
    renewal.start()
    try:
        yield bench
    finally:
        renewal.end()
        if renewal.why_lost:
            warnings.warn(f"{bench.name} was no more ours: {renewal.why_lost}", stacklevel=3)
        else:
            with suppress(ClientError):  # it ends by itself
                bench.give_lease()
