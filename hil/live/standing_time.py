"""Time of a bench as long as one of its processors stands for its debugger."""

from contextlib import suppress

from hil.live.held_time import HeldTime
from hil.vocab.verbs import VerbRefused


class StandingTime:
    """Time of a bench, held from when a first processor stands until all go on."""

    def __init__(self, held: HeldTime) -> None:
        self._held = held
        self._standing = set[str]()
        self._is_holding = False

    def note(self, name: str, is_standing: bool) -> None:
        """Note that a device's processor stands, or goes on."""
        if is_standing:
            self._stand(name)
        else:
            self._go_on(name)

    def _stand(self, name: str) -> None:
        self._standing.add(name)
        if not self._held.bench.real_time.is_held:
            with suppress(VerbRefused):  # something is real
                self._held.hold(True)
                self._is_holding = True

    def _go_on(self, name: str) -> None:
        self._standing.discard(name)
        if self._is_holding and not self._standing:
            self._is_holding = False
            self._held.hold(False)
