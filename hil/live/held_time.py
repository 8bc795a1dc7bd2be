"""Time of a bench that can be held: it stands, and goes on from where it stands."""

from collections.abc import Mapping
from dataclasses import dataclass

from hil.config.port_model import SERIAL
from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.sim.bench import BenchRuntime
from hil.vocab.device import Device
from hil.vocab.verbs import VerbRefused


@dataclass(frozen=True)
class HeldTime:
    """Time of a bench. While it is held, clients' bytes wait, and boards answer nothing."""

    bench: BenchRuntime
    configured: Configured
    devices: Mapping[str, Device]
    clock: WallClock

    def hold(self, is_held: bool) -> int:
        """Let time stand, or go on; answers the time.

        Raises:
            VerbRefused: there is something real, whose time cannot stand.
        """
        real_time, at_ns = self.bench.real_time, self.bench.now_ns
        if not real_time.is_on:
            raise VerbRefused("cannot", "the time of a bench in memory is its test's")
        if is_held and (real := self._real()):
            raise VerbRefused("cannot", f"{', '.join(real)}: the time of what is real cannot stand")
        if is_held != real_time.is_held:
            try:
                real_time.hold(is_held)
            except OSError as error:
                raise VerbRefused(
                    "failed", f"the core's thread could not be started: {error.strerror}"
                ) from error
            self.clock.anchor()
        return self.bench.now_ns if is_held else at_ns

    def _real(self) -> list[str]:
        adapters = [name for name, port in self.configured.config.tap_ports().items() if port.kind == SERIAL]
        return [*(name for name in self.devices if name not in self.bench.devices), *adapters]
