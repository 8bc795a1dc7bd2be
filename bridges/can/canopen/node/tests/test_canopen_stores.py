"""Stores that take time: nobody hears of success before it is known, whatever comes in between."""

import pytest
from canopen_rig import Rig

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.node.parameter_store import decode

SAVE_ALL, LOAD_ALL = "605#2310100173617665", "605#231110016C6F6164"
SAVED, LOADED = "585#6010100100000000", "585#6011100100000000"
FAILED, BUSY = "00000606", "22000008"
"""Codes of aborts: hardware error; not in the present state."""
GIVEN_UP = "605#8010100100000405"
CONFIGURE, NODE_7, LSS_STORE = "7E5#0401000000000000", "7E5#1107000000000000", "7E5#1700000000000000"


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.run(1)
    rig.memory_waits = True
    return rig


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize(("asks", "done"), [(SAVE_ALL, SAVED), (LOAD_ALL, LOADED)])
def test_the_answer_waits_for_the_memory(rig: Rig, asks: str, done: str, fails: bool) -> None:
    rig.memory_fails = fails
    assert rig.hear(asks) == []
    assert rig.run(5000) == [], "a store has no time-out of the client's silence"
    assert rig.end_store() == [done.replace("#60", "#80").replace("00000000", FAILED) if fails else done]
    assert rig.upload(0x1017) == bytes(2), "and others are answered again"


def test_a_save_by_segments_and_by_blocks_waits_too(rig: Rig) -> None:
    assert rig.hear("605#2110100104000000") == ["585#6010100100000000"]
    assert rig.hear("605#0773617665000000") == []
    assert rig.end_store() == ["585#2000000000000000"]
    assert rig.hear("605#C210100104000000") == ["585#A01010017F000000"]
    assert rig.hear("605#8173617665000000") == ["585#A2017F0000000000"]
    assert rig.hear("605#CD00000000000000") == []
    rig.memory_fails = True
    assert rig.end_store() == [f"585#80101001{FAILED}"]


def test_what_comes_in_between_is_refused_and_the_answer_still_follows(rig: Rig) -> None:
    rig.hear(SAVE_ALL)
    assert rig.hear("605#4017100000000000") == [f"585#80171000{BUSY}"]
    assert rig.hear(SAVE_ALL, "605#00") == [f"585#80101001{BUSY}", f"585#80000000{BUSY}"]
    assert rig.end_store() == [SAVED]


def test_a_client_that_has_given_up_hears_nothing_more(rig: Rig) -> None:
    rig.put(0x2003, 0, 5, 2)
    rig.hear(SAVE_ALL)
    assert rig.hear(GIVEN_UP) == []
    assert rig.upload(0x2003) == b"\5\0"
    assert rig.hear(SAVE_ALL) == [f"585#80101001{BUSY}"], "the memory is still being written"
    assert rig.end_store() == []
    assert decode(rig.kept).values.keys() == {0x200300}, "it was stored all the same"
    rig.hear(SAVE_ALL)
    assert rig.end_store() == [SAVED]


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize("command", ["8105", "8205"])
def test_a_reset_waits_for_what_the_memory_will_have(rig: Rig, command: str, fails: bool) -> None:
    rig.memory_fails = fails
    rig.put(0x1017, 0, 500, 2)
    rig.hear("000#0105", SAVE_ALL)
    rig.told()
    assert rig.hear("000#" + command, "605#4017100000000000", "000#0105") == []
    assert rig.node.state is NmtState.INITIALISING
    assert rig.told("entered") == ([("entered", "INITIALISING")] if command == "8105" else [])
    assert rig.end_store() == ["705#00"]
    assert rig.upload(0x1017) == (bytes(2) if fails else b"\xf4\1")
    assert rig.node.state is NmtState.PRE_OPERATIONAL


def test_the_power_goes_in_the_middle(rig: Rig) -> None:
    rig.put(0x1017, 0, 500, 2)
    rig.hear(SAVE_ALL)
    rig.node.power_off()
    rig.node.power_up(rig.now_ns)
    assert rig.hear("605#4017100000000000") == []
    assert rig.end_store() == ["705#00"]
    assert rig.upload(0x1017) == b"\xf4\1"
    rig.hear(SAVE_ALL)
    rig.node.power_off()
    assert rig.end_store() == []
    assert rig.run(10_000) == []


def test_lss_answers_when_it_is_stored(rig: Rig) -> None:
    rig.hear(CONFIGURE, NODE_7)
    assert rig.hear(LSS_STORE) == []
    assert rig.hear(LSS_STORE) == ["7E4#1702000000000000"], "another store cannot be begun"
    assert rig.download(0x1010, 1, b"save") == AbortCode.NOT_NOW
    assert rig.hear("7E5#5E00000000000000") == ["7E4#5E05000000000000"]
    assert rig.end_store() == ["7E4#1700000000000000"]
    rig.memory_fails = True
    rig.hear(LSS_STORE)
    assert rig.end_store() == ["7E4#1702000000000000"]
    rig.hear(LSS_STORE, "000#8100")
    assert rig.end_store() == ["707#00"], "the reset came before the answer"


def test_a_profile_is_stopped_by_a_reset_that_has_to_wait(rig: Rig) -> None:
    rig.hear(SAVE_ALL)
    rig.application.services.emergency(0x3210, 0x04)
    rig.run(2)
    rig.hear("000#8105")
    assert rig.node.counters()["error_register"] == 0
    rig.end_store()
    assert rig.upload(0x1001) == b"\0"
