"""CANopen nodes whose board's memory takes its time, as a daemon's: what is on the bus, and its replay."""

import io
from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest
from can_bench import config

from hil.compose.replay import replay
from hil.sim.bench import VIRTUAL
from hil.sim.input_log import InputLogWriter
from hil.sim.twin import Twin
from hil.testing import Bench

SETUP = config()
WRITE_500_MS = (0x605, bytes.fromhex("2B171000F4010000"))
SAVE = (0x605, bytes.fromhex("2310100173617665"))
READ = (0x605, bytes.fromhex("4017100000000000"))
CONFIGURE, STORE = (0x7E5, bytes.fromhex("0401000000000000")), (0x7E5, bytes.fromhex("1700000000000000"))
SAVED, FAILED = "585#6010100100000000", "585#8010100100000606"


class Later:
    """Memory that is written when the test says so."""

    def __init__(self) -> None:
        self.asked: list[Callable[[bool], bool]] = []

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        self.asked.append(answered)
        return None


class Rig:
    """Node 5 of a bench whose inputs are logged."""

    def __init__(self) -> None:
        self.file, self.store = io.StringIO(), Later()
        with Bench(SETUP) as fresh:
            memories = {name: device.nvm for name, device in fresh._runtime.devices.items()}
        log = InputLogWriter(self.file, "test", SETUP, memories)
        self.bench = Bench(SETUP, store=self.store, around=replace(VIRTUAL, log=log))
        self.bus = self.bench.canbus()
        self.tap = self.bench.tap("can0.a")
        self.tap.write(b"S6\rO\r")
        self.bench.run(ms=20)
        self.bus.read()

    def ask(self, *frames: tuple[int, bytes]) -> list[str]:
        """Send frames; answers what the node has sent 10 ms later."""
        for can_id, data in frames:
            self.tap.write(b"t%03X%d%s\r" % (can_id, len(data), data.hex().encode()))
            self.bench.run(ms=10)
        texts = [str(each.frame) for each in self.bus.read()]
        return [text for text in texts if not text.startswith(("605#", "7E5#"))]

    def end(self, durable: bool) -> list[str]:
        """End the store that is under way."""
        assert self.store.asked.pop(0)(durable)
        self.bench.run(ms=10)
        return self.ask()

    def is_replayed(self) -> bool:
        return replay(self.file.getvalue().splitlines(keepends=True)).difference() is None


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.mark.parametrize("durable", [True, False])
def test_a_save_is_answered_when_its_end_is_known(rig: Rig, durable: bool) -> None:
    rig.ask(WRITE_500_MS)
    assert rig.ask(SAVE) == []
    rig.bench.run(ms=400)
    assert rig.ask() == []
    assert rig.end(durable) == [SAVED if durable else FAILED]
    rig.bench.device("m1").reset()
    rig.bench.run(ms=20)
    assert rig.ask(READ)[-1] == ("585#4B171000F4010000" if durable else "585#4B17100000000000")
    assert rig.is_replayed()


def test_a_node_that_waits_for_its_memory_or_an_id_shows_the_id_in_use(rig: Rig) -> None:
    card = rig.bench._runtime.cards["m1.canopen"]
    ids = [card.node_id]
    for data in ("1107000000000000", "1700000000000000"):
        rig.ask(CONFIGURE, (0x7E5, bytes.fromhex(data)))
    rig.end(True)
    rig.ask((0, b"\x81\5"))
    ids.append(card.node_id)
    rig.ask((0x607, SAVE[1]), (0, b"\x81\7"))
    ids.append(card.node_id)
    rig.end(True)
    for data in ("11FF000000000000", "0400000000000000"):
        rig.ask(CONFIGURE, (0x7E5, bytes.fromhex(data)))
    rig.ask((0, b"\x82\7"))
    assert [*ids, card.node_id] == [5, 7, 7, 255]


def test_lss_is_answered_when_its_end_is_known(rig: Rig) -> None:
    assert rig.ask(CONFIGURE, STORE) == []
    assert rig.end(False) == ["7E4#1702000000000000"]
    assert rig.ask(STORE) == []
    assert rig.end(True) == ["7E4#1700000000000000"]
    assert rig.is_replayed()


def test_the_power_goes_while_it_stores(rig: Rig) -> None:
    rig.ask(WRITE_500_MS, SAVE)
    fault = rig.bench.fault("node_brown_out", "m1")
    rig.bench.run(ms=20)
    fault.clear()
    rig.bench.run(ms=20)
    assert rig.ask(READ) == [], "neither node nor board knows what it has"
    assert rig.end(True) == ["705#00"]
    assert rig.ask(READ) == ["585#4B171000F4010000"]
    assert rig.is_replayed()
