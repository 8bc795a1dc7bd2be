"""Verbs that are to be done at a later time."""

from collections import Counter
from collections.abc import Callable

from hil.sim.device import Device
from hil.sim.group import Group
from hil.sim.inputs import Do
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Effect, VerbRefused

Refused = Callable[[VerbRefused], None]


class LaterVerbs:
    """Power that comes anew, and a verb that ends motions, end those of a device that were to come."""

    def __init__(self) -> None:
        self._ends = Counter[str]()
        """How often a verb ended the motions of a device."""

    def note(self, device: Device, given: Do) -> None:
        """A verb is done now."""
        if device.verbs[given.verb].effect == Effect.ENDS:
            self._ends[device.name] += 1

    def add(self, group: Group, device: Device, given: Do, at_ns: int, on_refused: Refused) -> None:
        """A verb is to be done at a time that has not come; ``on_refused`` is called if it cannot be."""
        epoch = self._epoch(device)

        def due(now_ns: SimTimeNs) -> None:
            if epoch == self._epoch(device):
                try:
                    group.apply(device, given)
                except VerbRefused as refusal:
                    on_refused(refusal)

        group.at(at_ns, due)

    def _epoch(self, device: Device) -> tuple[int, int]:
        return self._ends[device.name], device.power_ups
