"""States of a node, what it keeps without power, its bus controller, and what its profile asks for."""

import pytest
from canopen_rig import IDENTITY, Rig, StubApplication

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.parameter_store import decode
from hil.vocab.time import FOREVER, NS_PER_MS

START, STOP = "000#0105", "000#0205"
HEARTBEAT_OF_10 = b"\x64\0\x0a\0"


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.run(1)
    return rig


@pytest.mark.parametrize("node_id", [0, 128, 254, -1, 256])
def test_ids_out_of_range(node_id: int) -> None:
    with pytest.raises(ValueError, match="1 to 127"):
        CanOpenNode(node_id, 125_000, StubApplication, IDENTITY, lambda _: None)


def test_states_are_told(rig: Rig) -> None:
    assert rig.told() == [("entered", "INITIALISING"), ("entered", "PRE_OPERATIONAL")]
    rig.hear(START, START, STOP, "000#8005", "000#8205")
    names = [name for _, name in rig.told("entered")]
    assert names == ["OPERATIONAL", "STOPPED", "PRE_OPERATIONAL", "PRE_OPERATIONAL"]
    rig.hear("000#8100")
    assert [name for _, name in rig.told("entered")] == ["INITIALISING", "PRE_OPERATIONAL"]


def test_what_it_hears_in_each_state(rig: Rig) -> None:
    lss = 0x7E5
    talking = (0x000, 0x080, 0x605, 0x705, lss)
    before = rig.node.can_ids
    assert before == talking
    rig.hear(START)
    assert rig.node.can_ids == (0x000, 0x080, 0x185, 0x205, 0x605, 0x705, lss)
    assert rig.node.can_ids is not before
    rig.hear(STOP)
    assert rig.node.can_ids == (0x000, 0x705, lss)
    assert Rig(node_id=255).node.can_ids == (lss,)
    rig.node.power_off()
    assert rig.node.can_ids == ()
    assert rig.node.due_ns == FOREVER
    assert rig.hear("000#8100", START) == []


def test_a_profile_is_called_when_it_is_due(rig: Rig) -> None:
    rig.application.due_ns = 5 * NS_PER_MS
    rig.node.step(rig.now_ns)  # as who calls it from outside has to
    rig.told()
    rig.run(4)
    assert rig.told() == []
    rig.run(6)
    assert rig.told() == [("step",)]


# ---- emergencies ----


def test_errors_of_the_profile_and_of_communication(rig: Rig) -> None:
    services = rig.application.services
    services.emergency(0x3210, 0x04)
    services.emergency(0x4310, 0x08, b"\1\2\3\4\5")
    assert rig.run(2) == ["085#1032050000000000", "085#10430D0102030405"]
    rig.hear("080#00")
    assert rig.upload(0x1001) == b"\x1d"
    services.emergency(0, 0x04)
    services.emergency(0, 0x08)
    assert rig.run(3) == ["085#0000190000000000", "085#0000110000000000"]
    rig.hear("080#")
    assert rig.upload(0x1001) == b"\0"
    assert rig.upload(0x1003) == b"\3"
    assert rig.upload(0x1003, 2) == b"\x10\x43\1\2"
    assert rig.node.counters() == {"state": "pre-operational", "error_register": 0, "last_error": 0x8240}


def test_the_history_has_eight(rig: Rig) -> None:
    for code in range(0x1001, 0x100C):
        rig.application.services.emergency(code, 0)
    rig.run(2)
    assert [rig.upload(0x1003, at) for at in (0, 1, 8)] == [b"\x08", b"\x0b\x10\0\0", b"\x04\x10\0\0"]


def test_emergencies_wait_while_it_is_stopped(rig: Rig) -> None:
    rig.hear(STOP)
    for code in range(0x1001, 0x1021):
        rig.application.services.emergency(code, 0)
    assert rig.run(100) == []
    sent = rig.hear("000#8005")
    assert (len(sent), sent[-1]) == (16, "085#2010000000000000")


def test_a_reset_forgets_errors(rig: Rig) -> None:
    rig.application.services.emergency(0x3210, 0x04)
    rig.hear("080#00")
    rig.hear("000#8205")
    assert rig.upload(0x1001) == b"\x05"
    rig.hear("000#8105")
    assert rig.upload(0x1001) == b"\0"
    assert rig.upload(0x1003) == b"\0"


def test_bus_off(rig: Rig) -> None:
    rig.hear(START)
    rig.told()
    node = rig.node
    node.bus_passive(2 * NS_PER_MS)
    assert rig.take() == ["085#2081110000000000"]
    node.bus_off(3 * NS_PER_MS)
    assert rig.told() == [("lost", "bus-off"), ("entered", "PRE_OPERATIONAL")]
    node.bus_off(4 * NS_PER_MS)
    node.bus_on(5 * NS_PER_MS)
    assert rig.told() == []
    assert rig.take() == ["085#4081110000000000", "085#0000110000000000", "085#0000000000000000"]
    node.bus_on(6 * NS_PER_MS)
    assert rig.take() == []


# ---- lost communication ----


@pytest.mark.parametrize(("behaviour", "state"), [(0, "PRE_OPERATIONAL"), (1, "OPERATIONAL"), (2, "STOPPED")])
def test_lost_heartbeat(rig: Rig, behaviour: int, state: str) -> None:
    rig.download(0x1016, 1, HEARTBEAT_OF_10)
    rig.put(0x1029, 1, behaviour, 1)
    rig.hear(START, "70A#7F")
    rig.told()
    assert rig.run(100.9) == []
    assert rig.run(101) == ["085#3081110A00000000"]
    assert rig.told("lost") == [("lost", "heartbeat")]
    assert rig.node.state.name == state


def test_behaviour_beyond_the_book(rig: Rig) -> None:
    assert rig.download(0x1029, 1, b"\3") == AbortCode.TOO_HIGH


def test_a_stopped_node_stays_so(rig: Rig) -> None:
    rig.download(0x1016, 1, HEARTBEAT_OF_10)
    rig.hear(STOP, "70A#7F")
    rig.run(500)
    assert rig.node.state is NmtState.STOPPED


def test_two_masters(rig: Rig) -> None:
    rig.download(0x1016, 1, HEARTBEAT_OF_10)
    rig.download(0x1016, 4, b"\x32\0\x0b\0")
    rig.hear("70A#05", "70B#05")
    assert rig.run(200) == ["085#3081110B00000000", "085#3081110A00000000"]
    assert rig.hear("70B#05", "70A#05") == ["085#0000110000000000", "085#0000000000000000"]


# ---- what is kept ----


def test_groups_of_parameters(rig: Rig) -> None:
    rig.put(0x1017, 0, 500, 2)
    rig.put(0x2003, 0, 5, 2)
    rig.put(0x6000, 0, 6, 1)
    for subindex, kept in ((2, {0x1017}), (3, {0x1017, 0x6000}), (4, {0x1017, 0x6000, 0x2003})):
        assert rig.download(0x1010, subindex, b"save") == 0
        assert {key >> 8 for key in decode(rig.kept).values} == kept
    assert rig.download(0x1011, 2, b"load") == 0
    assert {key >> 8 for key in decode(rig.kept).values} == {0x2003, 0x6000}
    rig.put(0x6000, 0, 0xFD, 1)  # the default
    rig.download(0x1010, 1, b"save")
    assert {key >> 8 for key in decode(rig.kept).values} == {0x1017, 0x2003}
    rig.download(0x1011, 1, b"load")
    assert decode(rig.kept).values == {}


def test_kept_communication_is_there_after_its_reset(rig: Rig) -> None:
    rig.map(0x1A00, [*rig.application.entries[4:5]])
    rig.put(0x1800, 2, 1, 1)
    rig.download(0x1010, 2, b"save")
    rig.put(0x1800, 2, 2, 1)
    rig.hear("000#8205", START)
    assert rig.upload(0x1800, 2) == b"\1"
    assert rig.hear("080#") == ["185#01"]


def test_a_memory_that_fails(rig: Rig) -> None:
    rig.memory_fails = True
    rig.put(0x2003, 0, 5, 2)
    assert rig.download(0x1010, 1, b"save") == AbortCode.HARDWARE
    rig.hear("000#8105")
    assert rig.upload(0x2003) == bytes(2)


def test_defaults_follow_the_id_and_what_is_kept_does_not(rig: Rig) -> None:
    rig.put(0x1801, 1, 0x8000_0285, 4)
    rig.put(0x1801, 1, 0x0000_02AA, 4)
    rig.download(0x1010, 1, b"save")
    again = Rig(node_id=9, kept=rig.kept)
    assert again.take() == ["709#00"]
    answers = again.hear("609#4000180100000000", "609#4001180100000000")
    assert answers == ["589#4300180189010000", "589#43011801AA020000"]


def test_a_section_of_another_dictionary(rig: Rig) -> None:
    rig.put(0x2003, 0, 5, 2)
    rig.download(0x1010, 1, b"save")
    kept = decode(rig.kept)
    kept.values |= {0x2ABC00: b"\1", 0x200300: b"\5", 0x160001: b"\0\0\x99\x29", 0x100000: bytes(4)}
    again = Rig(kept=kept.encode())
    assert again.take() == ["705#00"]
    assert again.upload(0x2003) == bytes(2)
    assert again.upload(0x1600) == b"\0"
    assert again.upload(0x1000) == b"\x92\1\2\0"


# ---- LSS ----


def test_a_node_without_an_id_waits_for_lss() -> None:
    rig = Rig(node_id=255)
    assert rig.run(1000) == []
    assert rig.node.state is NmtState.INITIALISING
    assert rig.hear("000#0100", "605#4000100000000000", "080#") == []
    rig.hear("7E5#0401000000000000")
    assert rig.hear("7E5#1107000000000000") == ["7E4#1100000000000000"]
    assert rig.hear("7E5#0400000000000000") == ["707#00"]
    assert rig.node.node_id == 7
    rig.hear("7E5#0401000000000000", "7E5#11FF000000000000", "7E5#0400000000000000")
    assert rig.hear("000#8207") == []
    assert rig.hear("7E5#4C00000000000000") == ["7E4#5000000000000000"]


def test_an_id_that_is_not_stored_is_lost_with_the_power(rig: Rig) -> None:
    rig.hear("7E5#0401000000000000", "7E5#1107000000000000")
    rig.node.power_up(rig.now_ns)
    assert rig.take()[-1] == "705#00"
    rig.hear("7E5#0401000000000000", "7E5#1107000000000000")
    assert rig.hear("7E5#1700000000000000") == ["7E4#1700000000000000"]
    rig.node.power_up(rig.now_ns)
    assert rig.take() == ["707#00"]
    assert rig.application.told[-1] == ("entered", "PRE_OPERATIONAL")
