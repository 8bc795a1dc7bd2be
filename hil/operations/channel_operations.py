"""Operations on channels of CAN buses: nodes without devices, from which programs outside send."""

from typing import Any

from hil.operations.table import Asked
from hil.sim.bench import BenchRuntime
from hil.sim.channels import ClientChannel
from hil.sim.input_check import channel_problem
from hil.sim.inputs import Attach, Detach, Frames
from hil.vocab.address import Address
from hil.vocab.desk_protocol import Done
from hil.vocab.verbs import VerbRefused


class ChannelOperations:
    """Operations on the channels of a bench."""

    def __init__(self, sim: BenchRuntime) -> None:
        self._sim = sim

    def attach(self, asked: Asked, node: str) -> Done:
        """Put a channel's node on a bus; answers its address, and how many frames it takes now."""
        if problem := channel_problem(self._sim, asked.target, node):
            raise VerbRefused("no_place", problem)
        at_ns = self._sim.apply_input(asked.target, Attach(node))[0]
        label = str(Address(asked.target, node))
        return Done(at_ns, {"node": label, "free": self._node(label).free})

    def detach(self, asked: Asked) -> Done:
        """Take a channel's node off its bus."""
        return Done(self._sim.apply_to(self._node(asked.target), Detach()), {})

    def transmit(self, asked: Asked, frames: list[str]) -> Done:
        """Send frames from a channel's node; answers how many were refused, and how many it takes now."""
        node = self._node(asked.target)
        if problem := node.frames_problem(frames):
            raise VerbRefused("bad_parameter", problem)
        before = node.refused
        at_ns = self._sim.apply_to(node, Frames(tuple(frames)))
        answer: dict[str, Any] = {"refused": node.refused - before, "free": node.free}
        return Done(at_ns, answer)

    def _node(self, target: str) -> ClientChannel:
        node = self._sim.taps.get(target)
        if not isinstance(node, ClientChannel):
            known = ", ".join(name for name, tap in self._sim.taps.items() if isinstance(tap, ClientChannel))
            raise VerbRefused("no_place", f"there is no channel {target!r}; there are {known or 'none'}")
        return node
