"""A joint of an arm and its board's main loop, with names instead of numbers."""

from hil.core.abi import WalterCall
from hil.core.core_axis import CoreAxis

_WALTER_CALLS = {name: int(call) for name, call in WalterCall.__members__.items()}


class CoreJoint(CoreAxis):
    """Joint of an arm; a firmware sees it as ``hil.vocab.firmware.ArmJoint``."""

    def loop(self, on: bool) -> None:
        """Stop the main loop where a control loop would be stopped."""
        if not on:
            self.do("stop")

    def do(self, call: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> float:
        return self._native.do(self.id, _WALTER_CALLS[call], x, y, z)
