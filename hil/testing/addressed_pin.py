"""Pin of a bench by its address: ``bench.pin("u1.D6")``."""

from hil.sim.twin import Twin
from hil.testing.faces import PinFace
from hil.vocab.address import pin_of
from hil.vocab.time import SimTimeNs


class AddressedPin:
    """Pin of a board: what it has done, and what it is now. ``name``: on the board, as in ``elbow.step``."""

    def __init__(self, face: PinFace, device: Twin, name: str) -> None:
        axis, self._name = pin_of(name)
        self._face, self._axis = face, device.axes.get(axis or device.axes.first)

    @property
    def edges(self) -> list[tuple[SimTimeNs, int]]:
        """Edges of the output so far: (simulated time in ns, level)."""
        return self._face.edges()

    @property
    def level(self) -> int:
        """Level now, 0 or 1. Raises ValueError: it is an input that tells none."""
        if axis := self._axis:
            if self._name in axis.kind.outputs:
                return axis.output_levels()[self._name]
            if self._name in axis.kind.inputs and (told := axis.kind.level_field(self._name)):
                return int(axis.get(told))
        raise ValueError(f"{self._name} is a pin whose level nothing tells")

    def set(self, level: int) -> None:
        """Drive an input, now. Raises ValueError: it is none."""
        self._face.set(level)
