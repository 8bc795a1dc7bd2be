"""Reservations of devices that have to stay as they are: by runs, and by dialogues with real boards."""

from collections.abc import Iterable, Mapping

from hil.vocab.address import owner_of
from hil.vocab.device import Device


class Reservations:
    """Devices by the runs that have axes of them, or wait for these."""

    def __init__(self, known: Mapping[str, Device]) -> None:
        self._known = known
        self._runs: dict[str, tuple[str, ...]] = {}

    def reserve(self, run: str, axes: Iterable[str]) -> None:
        """Give a run that was accepted the axes at these addresses until ``release``."""
        self._runs[run] = tuple(axes)

    def release(self, run: str) -> None:
        self._runs.pop(run, None)

    def taken(self) -> dict[str, str]:
        """Axes that are in a run or will be, each with the run that was accepted last."""
        return {axis: run for run, axes in self._runs.items() for axis in axes}

    def problems(self, devices: Iterable[str]) -> list[str]:
        """Reasons why these devices cannot be exchanged now, a line for each."""
        leaving = list(devices)
        taken = {owner_of(axis): run for axis, run in self.taken().items()}
        talking = [name for name in leaving if name in self._known and self._known[name].is_talking]
        return [
            f"{name} is in run {taken[name]}: wait for its end, or cancel it"
            for name in leaving
            if name in taken
        ] + [f"{name} is in a dialogue with its board: wait for its end" for name in talking]
