"""Debugger of a twin's processor, as the twin calls it."""

from typing import Protocol


class Debugger(Protocol):
    """Debugger of a processor: it hears what happens to it."""

    def halted(self) -> None:
        """Note that the processor stands. The group's time stands there too, if it is held now."""

    def loaded(self) -> None:
        """Note that it has got another program."""

    def removed(self) -> None:
        """Note that its device leaves the bench; its group is the caller's."""


class NoDebugger:
    """Debugger that is none."""

    def halted(self) -> None: ...

    def loaded(self) -> None: ...

    def removed(self) -> None: ...


NO_DEBUGGER: Debugger = NoDebugger()
