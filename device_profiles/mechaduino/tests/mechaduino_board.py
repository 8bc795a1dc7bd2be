"""Mechaduino that has started, for tests of its verbs."""

from typing import Any

import pytest

from hil.core import Snapshot
from hil.testing import Bench
from hil.vocab.verbs import VerbRefused

DEVICE: dict[str, Any] = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
BOOT_MS = 4500.0
RPM = 6.0
"""Degrees by the second."""


class Board:
    """A board that has started."""

    def __init__(self, **device: Any) -> None:
        self.bench = Bench({"bench": "t", "devices": {"m1": DEVICE | device}})
        self.axis = self.bench.axis("m1")
        self.port = self.bench.port("m1")
        self.device = self.bench.device("m1")
        self.run(BOOT_MS)
        self.port.read()

    def run(self, ms: float) -> Snapshot:
        self.bench.run(ms)
        assert self.device.failed is None
        return self.now

    @property
    def now(self) -> Snapshot:
        return self.axis.snapshot()

    def do(self, verb: str, **parameters: float | str) -> dict[str, Any]:
        return self.axis.do(verb, **parameters)

    def typed(self, data: bytes, ms: float = 200) -> bytes:
        self.port.write(data)
        self.run(ms)
        return self.port.read()

    def refusal(self, verb: str, **parameters: float | str) -> tuple[str, str]:
        before = self.now
        with pytest.raises(VerbRefused) as refused:
            self.do(verb, **parameters)
        assert self.now == before  # what is refused changes nothing
        said = str(refused.value).removeprefix("m1: ")
        return refused.value.code, said.removesuffix("; b.start() lets it start")
