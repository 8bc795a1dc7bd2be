"""Holds on devices that have to stay as they are: by runs, and by dialogues with real boards."""

from collections.abc import Iterable

from hil.live.places import Places


class Holds:
    """Devices by the runs that have them, or wait for them."""

    def __init__(self, places: Places) -> None:
        self._places = places
        self._runs: dict[str, tuple[str, ...]] = {}

    def take(self, run: str, devices: Iterable[str]) -> None:
        """Give a run that was accepted these devices until ``release``."""
        self._runs[run] = tuple(devices)

    def release(self, run: str) -> None:
        self._runs.pop(run, None)

    def taken(self) -> dict[str, str]:
        """Devices that are in a run or will be, each with the run that was accepted last."""
        return {device: run for run, devices in self._runs.items() for device in devices}

    def problems(self, devices: Iterable[str]) -> list[str]:
        """Reasons why these devices cannot be exchanged now, a line for each."""
        leaving, taken, boards = list(devices), self.taken(), self._places.boards
        talking = [name for name in leaving if name in boards and boards[name].end.is_busy]
        return [
            f"{name} is in run {taken[name]}: wait for its end, or cancel it"
            for name in leaving
            if name in taken
        ] + [f"{name} is in a dialogue with its board: wait for its end" for name in talking]
