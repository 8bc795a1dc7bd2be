"""Nodes of a CAN bus by their names, by their numbers on the wire, and by what they want to hear."""

from collections.abc import Sequence

from hil.wire.can.can_frame import CanFrame
from virtual_ports.can.bus_node import BusNode

MOST_NODES = 256
_KEPT_IDENTIFIERS = 4096


class BusNodes(dict[str, BusNode]):
    """Nodes by name. Only ``join`` and ``leave`` change which there are."""

    def __init__(self) -> None:
        super().__init__()
        self._of: list[BusNode | None] = []
        self._wanting: dict[tuple[int, bool], list[BusNode]] = {}
        """Nodes that want an identifier, as far as it was asked for."""

    def free_index(self, name: str) -> int:
        """Number for a new node.

        Raises:
            ValueError: the name is taken, or all numbers are.
        """
        if name in self:
            raise ValueError(f"{name} is on the bus already")
        index = next((at for at, node in enumerate(self._of) if node is None), len(self._of))
        if index >= MOST_NODES:
            raise ValueError(f"a bus has at most {MOST_NODES} nodes")
        return index

    def join(self, node: BusNode) -> None:
        self[node.name] = node
        self._of[node.index : node.index + 1] = [node]
        self.changed()

    def leave(self, name: str) -> None:
        self._of[self.pop(name).index] = None
        self.changed()

    def changed(self) -> None:
        """Note that what nodes want may have changed."""
        self._wanting.clear()

    def at(self, index: int) -> BusNode | None:
        """Node of a number."""
        return self._of[index]

    def wanting(self, frame: CanFrame) -> Sequence[BusNode]:
        """Nodes that want a frame, by its identifier."""
        key = frame.id, frame.is_extended
        found = self._wanting.get(key)
        if found is None:
            if len(self._wanting) >= _KEPT_IDENTIFIERS:
                self._wanting.clear()
            found = self._wanting[key] = [node for node in self._of if node and node.wants(frame)]
        return found
