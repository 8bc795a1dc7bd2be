"""The drive as a node's application, under the ``canopen`` library's profile 402, by SDO and by PDO."""

import io
from typing import Any

import canopen
import pytest
from canopen.objectdictionary.eds import import_eds
from canopen.profiles.p402 import BaseNode402
from drive_rig import SimpleAxis

from bridges.can.canopen.cia402.profile_drive import ProfileDrive
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import Identity
from bridges.can.canopen.node.eds import eds_text
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import NS_PER_MS

NODE = 5
IDENTITY = Identity(0x1122, 402, 1, 7, "drive")


class World(canopen.Network):
    """Network with one drive, in whose time each frame of the master takes a millisecond."""

    def __init__(self, axis: SimpleAxis) -> None:
        super().__init__()
        self.axis = axis
        self.node = CanOpenNode(NODE, 1_000_000, self._make, IDENTITY, self._hear)
        self.node.power_up(0)

    def _make(self, services: CanOpenNode) -> ProfileDrive:
        self.drive = ProfileDrive(self.axis, services)
        return self.drive

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        self.node.hear(CanFrame(can_id, b"" if remote else bytes(data), False, remote), self.axis.now_ns)
        self.run(1)

    def run(self, ms: float) -> None:
        until_ns = self.axis.now_ns + round(ms * NS_PER_MS)
        while self.node.due_ns <= until_ns:
            self.axis.now_ns = max(self.axis.now_ns, self.node.due_ns)
            self.node.step(self.axis.now_ns)
        self.axis.now_ns = until_ns

    def _hear(self, frame: CanFrame) -> None:
        self.notify(frame.id, bytearray(frame.data), self.axis.now_ns / 1e9)


@pytest.fixture
def world() -> World:
    return World(SimpleAxis())


@pytest.fixture
def master(world: World) -> BaseNode402:
    text = eds_text(world.node.dictionary, IDENTITY, "drive.eds")
    node = BaseNode402(NODE, import_eds(io.StringIO(text), NODE))
    world.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = 0.001
    node.nmt.state = "OPERATIONAL"
    return node


def test_states_by_sdo(master: BaseNode402) -> None:
    assert master.state == "SWITCH ON DISABLED"
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "SWITCH ON DISABLED"):
        master.state = state
        assert master.state == state
    master.state = "OPERATION ENABLED"
    master.sdo[0x605A].raw = 6
    master.state = "QUICK STOP ACTIVE"
    assert master.state == "QUICK STOP ACTIVE"


def test_modes_by_sdo(master: BaseNode402) -> None:
    for mode in ("PROFILED VELOCITY", "PROFILED TORQUE", "HOMING", "CYCLIC SYNCHRONOUS POSITION"):
        assert master.is_op_mode_supported(mode)
        master.op_mode = mode
        assert master.op_mode == mode
    assert not master.is_op_mode_supported("INTERPOLATED POSITION")


def test_homing_by_sdo(master: BaseNode402, world: World) -> None:
    master.sdo[0x6098].raw = 34
    master.sdo[0x6099][2].raw = 720_000
    assert master.homing(timeout=10)
    assert master.is_homed()
    assert world.axis.look().position_deg * 1000 - master.sdo[0x6064].raw == pytest.approx(100_000, abs=1)


def test_a_fault_is_told_and_reset(master: BaseNode402, world: World) -> None:
    master.state = "OPERATION ENABLED"
    world.axis.off_by_deg = 100.0
    world.run(100)
    assert [error.code for error in master.emcy.active] == [0x8611]
    assert master.is_faulted()
    assert master.sdo[0x1001].raw == 0x21
    world.axis.off_by_deg = 0.0
    master.controlword = 0x80
    assert master.state == "SWITCH ON DISABLED"
    assert master.emcy.active == []
    assert master.sdo[0x1001].raw == 0


def test_a_refusal_has_its_code(master: BaseNode402) -> None:
    for index, subindex, data, code in (
        (0x6060, 0, b"\x07", 0x0609_0030),
        (0x6041, 0, b"\x00\x00", 0x0601_0002),
        (0x6081, 0, bytes(4), 0x0609_0032),
        (0x6080, 0, b"\xff\xff\x00\x00", 0x0609_0031),
        (0x6079, 0, b"\x00", 0x0602_0000),
        (0x607D, 3, bytes(4), 0x0609_0011),
        (0x6040, 0, b"\x00", 0x0607_0013),
        (0x607D, 1, b"\xff\xff\xff\x7f", 0x0609_0036),
    ):
        if code == 0x0609_0036:
            master.sdo.download(0x607D, 2, bytes(4))
        with pytest.raises(canopen.SdoAbortedError) as refused:
            master.sdo.download(index, subindex, data)
        assert refused.value.code == code, hex(index)


def test_pdos_as_they_are_by_default(master: BaseNode402, world: World) -> None:
    master.nmt.state = "PRE-OPERATIONAL"
    master.pdo.read()
    assert [[each.index for each in pdo] for pdo in master.tpdo.values()] == [
        [0x6041],
        [0x6041, 0x6061],
        [0x6041, 0x6064],
        [0x6041, 0x606C],
    ]
    assert not any(pdo.enabled for pdo in master.tpdo.values())
    assert [pdo.enabled for pdo in master.rpdo.values()] == [True, False, False, False]
    master.setup_402_state_machine()
    master.nmt.state = "OPERATIONAL"
    master.state = "OPERATION ENABLED"
    assert master.homing(timeout=10)
    master.op_mode = "PROFILED POSITION"  # which takes no RPDO that has a controlword beside the mode
    assert master.state == "OPERATION ENABLED"
    assert world.axis.is_on


def test_states_by_pdo(master: BaseNode402, world: World) -> None:
    master.nmt.state = "PRE-OPERATIONAL"
    master.pdo.read()
    master.tpdo[2].enabled = True
    master.tpdo[2].save()
    master.setup_402_state_machine()
    master.nmt.state = "OPERATIONAL"  # with it the first of them comes
    assert master.tpdo_values == {0x6041: 0x250, 0x6061: 1}
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"):
        master.state = state
        assert master.tpdo_values[0x6041] == world.drive.read(0x6041, 0, world.axis.now_ns)
    assert world.axis.is_on


def test_positions_by_sync(master: BaseNode402, world: World) -> None:
    master.nmt.state = "PRE-OPERATIONAL"
    master.pdo.read()
    for pdo in (master.rpdo[3], master.tpdo[3]):
        pdo.trans_type, pdo.enabled = 1, True
        pdo.save()
    master.nmt.state = "OPERATIONAL"
    master.op_mode = "CYCLIC SYNCHRONOUS POSITION"
    master.state = "OPERATION ENABLED"
    master.sdo[0x60C2][1].raw = 2  # a millisecond for each of two frames
    target = master.rpdo[3]
    target["Controlword"].raw = 0x0F
    for k in range(1, 21):
        target["Target position"].raw = 50 * k
        target.transmit()
        world.sync.transmit()
        seen = master.tpdo[3]
        assert seen["Position actual value"].raw == 50 * max(k - 1, 0)
        assert seen["Statusword"].raw & 0x1000
