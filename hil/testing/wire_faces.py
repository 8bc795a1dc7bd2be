"""Faces that buses give of their wires to tests."""

from collections.abc import Iterable
from typing import Any

from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientTap
from hil.testing.faces import TapFace
from hil.testing.given import NamedThings
from hil.vocab.address import owner_of
from hil.vocab.bus import WireKind


class WireFaces:
    """Faces that the buses of a bench give, each made when first asked for. ``bench``: the ``Bench``."""

    def __init__(self, bench: Any, runtime: BenchRuntime, kinds: Iterable[WireKind]) -> None:
        self._bench, self._runtime = bench, runtime
        self._kits = {kind.key: kind.kit for kind in kinds if kind.kit}
        self._made: dict[tuple[str, str], Any] = {}

    def wire(self, key: str, name: str) -> Any:
        """Face of a wire. Raises KeyError: there is none, or its bus has no faces."""
        __tracebackhide__ = True
        if (key, name) not in self._made:
            kit = NamedThings("bus", self._kits)[key]
            wire = NamedThings(kit.what, self._runtime.wires_of(key))[name]
            self._made[key, name] = kit.face(self._bench, self._runtime, wire)
        return self._made[key, name]

    def tap(self, name: str, tap: ClientTap) -> TapFace:
        """Make the face of a tap."""
        kit = self._kits.get(self._runtime.wires[owner_of(name)].kind)
        made: TapFace = ((kit and kit.tap_face) or TapFace)(self._runtime, tap)
        return made
