"""Any frame at any time: a node never raises, and goes on working.

``HIL_FUZZ`` sets how many frames are tried (100,000; ``make fuzz``: 10,000,000), ``HIL_FUZZ_SEED`` where they
start.
"""

import os
import random

import pytest
from canopen_rig import NODE, Rig
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.parameter_store import KeptSection, decode
from bridges.can.frames.can_frame import CanFrame, check
from hil.vocab.time import FOREVER, NS_PER_MS

CASES = int(os.environ.get("HIL_FUZZ", "100000"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
AT_A_TIME = 5000
"""Frames that one node gets."""
IDS = (0x000, 0x080, 0x205, 0x305, 0x405, 0x505, 0x605, 0x605, 0x605, 0x70A, 0x705, 0x7E5, 0x185)
INDEXES = (
    *(0x1001, 0x1003, 0x1005, 0x1006, 0x1007, 0x100C, 0x100D, 0x1010, 0x1011, 0x1014, 0x1015, 0x1016, 0x1017),
    *(0x1019, 0x1021, 0x1029, 0x1400, 0x1401, 0x1600, 0x1601, 0x1800, 0x1801, 0x1A00, 0x1A01),
    *range(0x2000, 0x200C),
)
COMMANDS = (
    0x23,
    0x2B,
    0x2F,
    0x21,
    0x40,
    0x60,
    0x70,
    0x00,
    0x10,
    0x01,
    0x80,
    0xA0,
    0xA4,
    0xA3,
    0xA2,
    0xA1,
    0xC2,
    0xC6,
)
LSS = (0x04, 0x11, 0x13, 0x15, 0x17, 0x40, 0x41, 0x42, 0x43, 0x46, 0x4B, 0x4C, 0x51, 0x5A, 0x5E)
NMT = (1, 1, 1, 2, 128, 129, 130)
WORDS = (b"save", b"load", bytes(4), b"\x20\0\x09\x20", b"\x10\0\x03\x20", b"\x85\1\0\x80", b"\x85\1\0\0")


class Source:
    """Frames that are nearly right."""

    def __init__(self, seed: int) -> None:
        self.chance = random.Random(seed)

    def frame(self) -> CanFrame:
        chance = self.chance
        can_id = chance.choice(IDS)
        data = bytearray(self._data(can_id))
        for _ in range(chance.choice((0, 0, 0, 1, 2))):
            if data:
                data[chance.randrange(len(data))] = chance.randrange(256)
        if chance.random() < 0.05:
            data = bytearray(chance.randbytes(chance.randrange(9)))
        if chance.random() < 0.02:
            can_id = chance.randrange(0x800)
        if chance.random() < 0.03:
            return CanFrame(can_id, b"", False, True, chance.randrange(9))
        return CanFrame(can_id, bytes(data), chance.random() < 0.01)

    def _data(self, can_id: int) -> bytes:
        chance = self.chance
        if can_id == 0:
            return bytes((chance.choice(NMT), chance.choice((0, NODE, NODE, 6))))
        if can_id == 0x605:
            head = bytes((chance.choice(COMMANDS),)) + chance.choice(INDEXES).to_bytes(2, "little")
            value = chance.choice(WORDS) if chance.random() < 0.4 else bytes((chance.randrange(256), 0, 0, 0))
            return head + bytes((chance.randrange(4),)) + value
        if can_id == 0x7E5:
            return bytes((chance.choice(LSS), chance.randrange(3))) + chance.randbytes(6)
        return chance.randbytes(chance.choice((0, 1, 4, 6, 8)))


def test_fuzz_of_frames() -> None:
    """``HIL_FUZZ`` frames and times. What is sent could be sent; and a node does all again after a reset."""
    source = Source(SEED)
    chance = source.chance
    sent = 0
    for _ in range(0, CASES, AT_A_TIME):
        rig = Rig()
        rig.listeners.append(check)
        for _ in range(min(CASES, AT_A_TIME)):
            rig.node.hear(source.frame(), rig.now_ns)
            if chance.random() < 0.1:
                rig.advance(rig.now_ns / NS_PER_MS + chance.choice((0, 1, 10, 2000)))
            if len(rig.sent) > AT_A_TIME:
                sent += len(rig.take())
                rig.told()
        sent += len(rig.take())
        works(rig)
        works(Rig(kept=rig.kept))
    assert sent > CASES / 10


def works(rig: Rig) -> None:
    """Look whether a node is as it should be after power-on, but for what it has kept."""
    rig.memory_fails = False
    rig.take()
    rig.node.power_up(rig.now_ns)
    node_id = rig.node.node_id
    if node_id == 255:
        assert rig.hear("7E5#4C00000000000000") == ["7E4#5000000000000000"]
        return
    assert f"{0x700 + node_id:03X}#00" in rig.take()
    assert rig.node.state is NmtState.PRE_OPERATIONAL
    (answer,) = rig.hear(f"{0x600 + node_id:03X}#4018100100000000")
    assert answer == f"{0x580 + node_id:03X}#4318100122110000"


class AnyLife(RuleBasedStateMachine):
    """A node among all that can happen to it."""

    @initialize(node_id=st.sampled_from((NODE, 255)), seed=st.integers(0, 2**32))
    def begin(self, node_id: int, seed: int) -> None:
        self.rig = Rig(node_id)
        self.rig.listeners.append(check)
        self.source = Source(seed)
        self.is_on = True

    @rule(count=st.integers(1, 20))
    def frames(self, count: int) -> None:
        for _ in range(count):
            self.rig.node.hear(self.source.frame(), self.rig.now_ns)

    @rule(ms=st.sampled_from((0.1, 1, 5, 100, 3000)))
    def wait(self, ms: float) -> None:
        self.rig.advance(self.rig.now_ns / NS_PER_MS + ms)

    @rule(code=st.sampled_from((0, 0x2310, 0x8130)), bits=st.integers(0, 255))
    def emergency(self, code: int, bits: int) -> None:
        self.rig.application.services.emergency(code, bits)

    @rule(index=st.sampled_from((0x2003, 0x2005, 0x2009)))
    def change(self, index: int) -> None:
        self.rig.application.services.changed(index, 0)

    @rule(state=st.sampled_from(("bus_off", "bus_passive", "bus_on")))
    def bus(self, state: str) -> None:
        getattr(self.rig.node, state)(self.rig.now_ns)

    @rule(fails=st.booleans())
    def memory(self, fails: bool) -> None:
        self.rig.memory_fails = fails

    @rule(is_on=st.booleans())
    def power(self, is_on: bool) -> None:
        self.is_on = is_on
        if is_on:
            self.rig.node.power_up(self.rig.now_ns)
        else:
            self.rig.node.power_off()
            self.rig.take()

    @invariant()
    def it_is_silent_without_power(self) -> None:
        if not self.is_on:
            assert self.rig.take() == []
            assert self.rig.node.due_ns == FOREVER
            assert self.rig.node.can_ids == ()

    @invariant()
    def what_is_due_is_done(self) -> None:
        rig = self.rig
        rig.advance(rig.now_ns / NS_PER_MS)
        assert rig.node.due_ns > rig.now_ns
        assert all(0 <= can_id <= 0x7FF for can_id in rig.node.can_ids)
        assert rig.node.state is NmtState.INITIALISING or rig.node.node_id <= 127
        assert rig.node.counters()["error_register"] in range(256)

    def teardown(self) -> None:
        if hasattr(self, "rig"):
            works(self.rig)


TestAnyLife = pytest.mark.long(AnyLife.TestCase)
TestAnyLife.settings = settings(max_examples=60, stateful_step_count=40)


@given(st.binary(max_size=60))
def test_any_section(section: bytes) -> None:
    for kept in (section, b"COP1" + section, KeptSection(0, 0, {0x2003 << 8: section}).encode()):
        assert Rig(kept=kept).take()[0] == "705#00"


def test_a_damaged_section_is_told() -> None:
    kept = bytearray(KeptSection(9, 125_000, {0x2003 << 8: b"\x05\0"}).encode())
    assert Rig(kept=bytes(kept)).take() == ["709#00"]
    for at in range(len(kept)):
        kept[at] ^= 0x40
        with pytest.raises(ValueError, match="CRC"):
            decode(bytes(kept))
        rig = Rig(kept=bytes(kept))
        assert rig.take() == ["705#00", "085#0063000000000000"]
        assert rig.upload(0x2003) == bytes(2)
        kept[at] ^= 0x40
