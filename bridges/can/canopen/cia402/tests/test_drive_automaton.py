"""The state machine against a table written here, for itself, and against a random master."""

import pytest
from drive_rig import DriveRig, SimpleAxis
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from bridges.can.canopen.canopen_codes import NmtState

NR, SOD, RTSO, SO, OE, QSA, FRA, F = 0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08
NAMES = {NR: "NR", SOD: "SOD", RTSO: "RTSO", SO: "SO", OE: "OE", QSA: "QSA", FRA: "FRA", F: "F"}
SHUTDOWN, SWITCH_ON, ENABLE, DISABLE, QUICK_STOP, RESET = 0x06, 0x07, 0x0F, 0x00, 0x02, 0x80

# By hand from the standard's figure: state, controlword, state after it. What is not here changes nothing.
FIGURE = {
    (SOD, SHUTDOWN): RTSO,  # 2
    (RTSO, SWITCH_ON): SO,  # 3
    (RTSO, ENABLE): OE,  # 3 and 4
    (SO, ENABLE): OE,  # 4
    (OE, SWITCH_ON): SO,  # 5
    (SO, SHUTDOWN): RTSO,  # 6
    (RTSO, DISABLE): SOD,  # 7
    (RTSO, QUICK_STOP): SOD,  # 7
    (OE, SHUTDOWN): RTSO,  # 8
    (OE, DISABLE): SOD,  # 9
    (SO, DISABLE): SOD,  # 10
    (SO, QUICK_STOP): SOD,  # 10
    (OE, QUICK_STOP): QSA,  # 11
    (QSA, DISABLE): SOD,  # 12
    (F, RESET): SOD,  # 15
    (QSA, ENABLE): OE,  # 16, where the drive stays
}
WAYS = {SOD: (), RTSO: (SHUTDOWN,), SO: (SHUTDOWN, SWITCH_ON), OE: (SHUTDOWN, SWITCH_ON, ENABLE)}


def in_state(state: int) -> DriveRig:
    """Drive in a state, that stays in it after a quick stop."""
    rig = DriveRig()
    rig.write(0x605A, 6)
    rig.write(0x605C, 0)
    if state == F:
        rig.axis.refuses = "enable"
        rig.control(SHUTDOWN, SWITCH_ON, ENABLE)
        rig.axis.refuses = ""
        rig.control(DISABLE)
    elif state == QSA:
        rig.control(*WAYS[OE], QUICK_STOP)
    else:
        rig.control(*WAYS[state])
    assert rig.status & 0x4F == state & 0x4F
    return rig


@pytest.mark.parametrize("state", [SOD, RTSO, SO, OE, QSA, F], ids=NAMES.get)
@pytest.mark.parametrize("word", [SHUTDOWN, SWITCH_ON, ENABLE, DISABLE, QUICK_STOP, RESET], ids=hex)
def test_a_controlword_leads_where_the_figure_says(state: int, word: int) -> None:
    rig = in_state(state)
    meant = DISABLE if word == RESET and state != F else word
    after = FIGURE.get((state, meant), state)
    rig.control(word)
    mask = 0x4F if after in (SOD, F) else 0x6F
    assert NAMES[rig.status & mask] == NAMES[after]
    assert rig.axis.is_on == (after in (OE, QSA))


def test_it_is_not_ready_until_its_board_is() -> None:
    axis = SimpleAxis(is_ready=False)
    rig = DriveRig(axis)
    rig.run(25)
    assert rig.status & 0x4F == NR
    rig.control(SHUTDOWN)
    assert rig.status & 0x4F == NR
    axis.is_ready = True
    rig.run(10)
    assert rig.status & 0x4F == SOD


def test_every_change_is_told() -> None:
    rig = DriveRig()
    rig.said.clear()
    rig.control(SHUTDOWN, SWITCH_ON, ENABLE, ENABLE)
    assert [value & 0x6F for index, value in rig.said if index == 0x6041] == [RTSO, SO, OE]


@pytest.mark.parametrize(
    ("option", "ends_in", "stop"),
    [(0, SOD, 0), (1, SOD, 1), (2, SOD, 2), (3, SOD, 3), (5, QSA, 1), (6, QSA, 2), (7, QSA, 3)],
)
def test_a_quick_stop_is_as_its_option_says(option: int, ends_in: int, stop: int) -> None:
    rig = DriveRig()
    rig.write(0x605A, option)
    rig.enable(3)
    rig.write(0x60FF, 360_000)
    rig.run(500)
    rig.axis.calls.clear()
    rig.control(QUICK_STOP)
    assert rig.status & 0x4F == (SOD if option == 0 else QSA)
    begin_ns = rig.now_ns
    while rig.axis.look().is_moving:
        rig.run(1)
    seconds = (rig.now_ns - begin_ns) / 1e9
    assert seconds == pytest.approx({0: 0, 1: 0.1, 2: 0.01, 3: 0}[stop], abs=0.0011)
    rig.run(20)
    assert rig.status & 0x4F == (SOD if ends_in == SOD else QSA)
    assert ("stop", "prejudice") in rig.axis.calls or stop != 3
    assert rig.axis.is_on == (ends_in == QSA)
    if ends_in == QSA:
        assert rig.status & 0x400
        rig.control(ENABLE)
        assert rig.status & 0x6F == OE


@pytest.mark.parametrize(("index", "word", "state"), [(0x605B, SHUTDOWN, RTSO), (0x605C, SWITCH_ON, SO)])
@pytest.mark.parametrize("option", [0, 1])
def test_operation_ends_on_a_ramp_or_at_once(index: int, word: int, state: int, option: int) -> None:
    rig = DriveRig()
    rig.write(index, option)
    rig.enable(3)
    rig.write(0x60FF, 360_000)
    rig.run(500)
    rig.control(word)
    assert rig.state == (OE if option else state)
    rig.run(99)
    assert rig.state == (OE if option else state)
    rig.run(3)
    assert rig.state == state
    assert not rig.axis.is_on


def test_a_ramp_towards_its_end_may_be_called_off() -> None:
    rig = DriveRig()
    rig.enable(3)
    rig.write(0x60FF, 360_000)
    rig.run(500)
    rig.control(SWITCH_ON)
    rig.run(50)
    rig.control(ENABLE)
    rig.run(200)
    assert rig.state == OE
    assert rig.read(0x606C) == 360_000


@pytest.mark.parametrize(("option", "ms"), [(0, 0), (1, 100), (2, 10), (3, 0)])
def test_a_fault_is_as_its_reaction_says(option: int, ms: int) -> None:
    rig = DriveRig()
    rig.write(0x605E, option)
    rig.enable(3)
    rig.write(0x60FF, 360_000)
    rig.run(500)
    rig.axis.fault_code = 0x7305
    rig.run(1)
    assert rig.emergencies == [0x7305]
    assert rig.read(0x603F) == 0x7305
    assert rig.status & 0x4F == (FRA if ms else F) or option == 3
    rig.run(ms - 2 if ms else 0)
    assert rig.status & 0x4F == (FRA if ms else F) or option == 3
    rig.run(4)
    assert rig.status & 0x4F == F
    assert not rig.axis.is_on
    rig.control(DISABLE, RESET)
    assert rig.status & 0x4F == SOD
    assert rig.emergencies == [0x7305, 0]
    assert rig.read(0x603F) == 0


def test_a_fault_that_is_still_there_stays() -> None:
    rig = in_state(F)
    rig.axis.fault_code = 0x7305
    rig.axis.refuses = "clear_fault"
    rig.control(RESET)
    assert rig.status & 0x4F == F


def test_only_a_rising_reset_bit_resets() -> None:
    rig = DriveRig()
    rig.control(0x86, 0x87)
    rig.axis.refuses = "enable"
    rig.control(0x8F)
    rig.axis.refuses = ""
    rig.control(0x80)
    assert rig.status & 0x4F == F
    rig.control(0x00, 0x80)
    assert rig.status & 0x4F == SOD


def test_what_a_board_refuses_is_a_fault() -> None:
    rig = DriveRig()
    rig.enable(1)
    rig.axis.refuses = "follow"
    rig.write(0x607A, 1000)
    rig.control(0x1F)
    assert rig.emergencies == [0xFF02]
    assert rig.status & 0x4F == F
    assert "follow is refused" in rig.drive.why


@pytest.mark.parametrize("lost", ["heartbeat", "guarding", "bus-off"])
@pytest.mark.parametrize(("option", "state"), [(0, OE), (1, F), (2, SOD), (3, SOD)])
def test_a_lost_connection_is_as_its_option_says(lost: str, option: int, state: int) -> None:
    rig = DriveRig()
    rig.write(0x6007, option)
    rig.enable(1)
    rig.drive.lost(lost, rig.now_ns)
    rig.run(20)
    assert rig.status & (0x6F if state == OE else 0x4F) == state
    assert rig.emergencies == []  # the node sends it
    rig.control(0x80)
    assert rig.emergencies == []


def test_a_stopped_node_has_lost_its_connection() -> None:
    rig = DriveRig()
    rig.enable(1)
    rig.drive.entered(NmtState.STOPPED, rig.now_ns)
    rig.run(20)
    assert rig.read(0x603F) == 0x8100


def test_a_drive_without_power_has_no_connection_to_lose() -> None:
    rig = DriveRig()
    rig.drive.lost("heartbeat", rig.now_ns)
    assert rig.status & 0x4F == SOD
    assert rig.emergencies == []


def test_a_reset_takes_the_power_off() -> None:
    rig = DriveRig()
    rig.enable(3)
    rig.drive.entered(NmtState.INITIALISING, rig.now_ns)
    assert rig.status & 0x4F == SOD
    assert not rig.axis.is_on


def test_all_that_a_pdo_has_is_there_at_once() -> None:
    rig = DriveRig()
    rig.enable(1)
    rig.receive({0x6040: 0x1F, 0x607A: 90_000})
    rig.run(600)
    assert rig.read(0x6064) == 90_000
    rig.receive({0x6040: 0x0F, 0x6060: 3, 0x60FF: 360_000})
    rig.run(200)
    assert rig.read(0x606C) == 360_000


class Master(RuleBasedStateMachine):
    """Master that writes any controlword at any time. What the state is has to follow from the figure."""

    @initialize(option=st.sampled_from([0, 2, 6]), ramps=st.booleans())
    def begin(self, option: int, ramps: bool) -> None:
        self.rig = DriveRig()
        self.rig.write(0x605A, option)
        self.rig.write(0x605B, int(ramps))
        self.rig.write(0x605C, int(ramps))
        self.stays, self.ramps, self.powers_off = option == 6, ramps, option == 0
        self.state, self.last = SOD, 0

    def told(self) -> int:
        status = self.rig.status
        return status & (0x4F if status & 0x4F in (NR, SOD, F, FRA) else 0x6F)

    @rule(
        word=st.sampled_from([0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x3F, 0x5F, 0x10F, 0x80, 0x8F, 0x86, 0x0B])
    )
    def control(self, word: int) -> None:
        before, self.last = self.last, word
        self.rig.control(word)
        if self.state == F:
            self.state = SOD if word & 0x80 and not before & 0x80 else F
            return
        if not word & 2:
            meant = DISABLE
        elif not word & 4:
            meant = QUICK_STOP
        elif not word & 1:
            meant = SHUTDOWN
        else:
            meant = ENABLE if word & 8 else SWITCH_ON
        after = FIGURE.get((self.state, meant), self.state)
        if (self.state, meant) == (QSA, ENABLE) and not self.stays:
            after = QSA
        if after == QSA and self.state == OE and self.powers_off:
            after = SOD
        if self.state == OE and after in (SO, RTSO) and self.ramps:
            self.rig.run(2000)  # on its ramp it is still enabled
        self.state = after

    @rule(aim=st.integers(-400_000, 400_000), mode=st.sampled_from([1, 3, 4, 6, 8, 9]))
    def set_up(self, aim: int, mode: int) -> None:
        self.rig.write(0x6060, mode)
        self.rig.write(0x607A, aim)
        self.rig.write(0x60FF, aim)
        self.rig.write(0x6071, aim % 1000)

    @rule(ms=st.sampled_from([1, 7, 40]))
    def wait(self, ms: int) -> None:
        self.rig.sync()
        self.rig.run(ms)
        if self.state == QSA and not self.stays:
            self.rig.run(2000)
            self.state = SOD

    @precondition(lambda self: self.state in (OE, QSA))
    @rule()
    def break_loop(self) -> None:
        self.rig.axis.is_on = False
        self.rig.run(60)
        self.state = F

    @invariant()
    def agrees(self) -> None:
        if hasattr(self, "rig") and self.told() != self.state:
            excused = {(F, FRA)} if self.stays else {(F, FRA), (QSA, SOD)}  # from rest it is over at once
            assert (self.state, self.told()) in excused, (NAMES[self.state], hex(self.rig.status))
            self.state = F if self.told() == FRA else self.told()


TestMaster = pytest.mark.long(Master.TestCase)
TestMaster.settings = settings(max_examples=60, stateful_step_count=30, deadline=None)
