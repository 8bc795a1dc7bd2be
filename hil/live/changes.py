"""What apply and reload tell the rest of the daemon; who wants to know subscribes in the constructor."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Changed:
    """Names of devices, in order: ``removed``, ``restarted`` (what has the name is another device now) and
    ``added``."""

    removed: tuple[str, ...] = ()
    restarted: tuple[str, ...] = ()
    added: tuple[str, ...] = ()

    @property
    def left(self) -> tuple[str, ...]:
        """Devices that are there no more, though another may have the name."""
        return self.removed + self.restarted

    @property
    def begun(self) -> tuple[str, ...]:
        """Devices that are new, or not what they were."""
        return self.restarted + self.added


class Changes:
    """Who is told that the bench's devices were exchanged."""

    def __init__(self) -> None:
        self._at_once: list[Callable[[Changed], None]] = []
        self._afterwards: list[Callable[[Changed], Coroutine[Any, Any, None]]] = []
        self._reloads: list[tuple[Callable[[], None], Callable[[str], None]]] = []

    def at_once(self, call: Callable[[Changed], None]) -> None:
        """Call in the step that exchanges them, at its end. ``call`` must not raise."""
        self._at_once.append(call)

    def afterwards(self, call: Callable[[Changed], Coroutine[Any, Any, None]]) -> None:
        """Await after that step, when what has gone is closed. ``call`` must not raise."""
        self._afterwards.append(call)

    def around_reloads(self, begun: Callable[[], None], ended: Callable[[str], None]) -> None:
        """Call when a reload begins and when it has ended: why nothing has changed, in a line, or nothing."""
        self._reloads.append((begun, ended))

    def tell_begun(self) -> None:
        for begun, _ in self._reloads:
            begun()

    def tell_ended(self, trouble: str) -> None:
        for _, ended in self._reloads:
            ended(trouble)

    def tell_at_once(self, changed: Changed) -> None:
        for call in self._at_once:
            call(changed)

    async def tell_afterwards(self, changed: Changed) -> None:
        for call in self._afterwards:
            await call(changed)
