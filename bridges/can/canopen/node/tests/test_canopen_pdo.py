"""PDOs of a node: types of transmission, times, mapping and its procedure."""

import pytest
from canopen_rig import POSITION, TICKS, TORQUE, Rig, entry

from bridges.can.canopen.abort_codes import AbortCode

START = "000#0105"
SYNC = "080#"


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.run(1)
    rig.told()
    return rig


def number(rig: Rig, index: int, subindex: int = 0) -> int:
    data = rig.upload(index, subindex)
    assert isinstance(data, bytes)
    return int.from_bytes(data, "little", signed=True)


# ---- transmit PDOs ----


def test_types_of_sync(rig: Rig) -> None:
    for at, type_ in enumerate((1, 2, 240), 1):
        rig.map(0x1A00 + at, [TORQUE])
        rig.put(0x1800 + at, 2, type_, 1)
    assert rig.hear(START) == ["185#010000000000"]
    counts = [0, 0, 0]
    for _ in range(480):
        sent = rig.hear(SYNC)
        counts = [
            count + (f"{can_id}#0000" in sent)
            for count, can_id in zip(counts, ("285", "385", "485"), strict=True)
        ]
    assert counts == [480, 240, 2]


def test_type_0_is_sent_with_sync_if_something_has_changed(rig: Rig) -> None:
    rig.put(0x1800, 2, 0, 1)
    assert rig.hear(START) == []
    assert rig.hear(SYNC) == ["185#010000000000"]
    assert rig.hear(SYNC) == []
    rig.application.services.changed(TORQUE.index, 0)
    assert rig.run(5) == []
    assert rig.hear(SYNC) == ["185#050000000000"]
    assert rig.hear(SYNC) == []


def test_event_driven_ones(rig: Rig) -> None:
    assert rig.hear(START) == ["185#010000000000"]
    rig.application.services.changed(POSITION.index, 0)  # not mapped
    assert rig.run(2) == []
    rig.application.services.changed(TICKS.index, 0)
    rig.application.services.changed(TORQUE.index, 0)
    assert rig.run(3) == ["185#020000000000"]
    assert rig.hear(SYNC) == []
    rig.hear("000#8005")
    rig.application.services.changed(TICKS.index, 0)
    assert rig.run(4) == []


def test_event_timer_and_inhibit_time(rig: Rig) -> None:
    rig.map(0x1A00, [TICKS], enable=False)
    rig.put(0x1800, 3, 50, 2)  # 5 ms
    rig.put(0x1800, 5, 20, 2)
    rig.put(0x1800, 1, 0x185, 4)
    rig.hear(START)
    rig.run(30)
    rig.advance(30)
    rig.sent.clear()
    services = rig.application.services
    services.changed(TICKS.index, 0)
    rig.advance(31)
    services.changed(TICKS.index, 0)
    rig.advance(32)
    services.changed(TICKS.index, 0)
    rig.advance(80)
    # At 30 by the event, as soon as the inhibit time lets it the next, then by the timer.
    assert [f"{at_ms:g} {frame[4:6]}" for at_ms, frame in rig.sent] == ["30 1E", "35 23", "55 37", "75 4B"]


def test_sent_on_request(rig: Rig) -> None:
    rig.map(0x1A01, [TICKS])
    rig.put(0x1801, 2, 253, 1)
    rig.map(0x1A02, [TICKS])
    rig.put(0x1802, 2, 252, 1)
    rig.hear(START)
    assert rig.hear("285#R4") == ["285#01000000"]
    assert rig.hear("385#R4") == []  # no SYNC yet
    rig.run(4)
    assert rig.hear(SYNC) == []
    rig.run(9)
    assert rig.hear("285#R4", "385#R4") == ["285#09000000", "385#04000000"]
    assert rig.hear("185#R6") == ["185#090000000000"]
    rig.put(0x1801, 1, 0x4000_0285, 4)
    assert rig.hear("285#R4") == []
    rig.hear("000#8005")
    assert rig.hear("185#R6") == []


def test_sync_start_value(rig: Rig) -> None:
    rig.put(0x1019, 0, 10, 1)
    rig.map(0x1A00, [TICKS], enable=False)
    rig.put(0x1800, 2, 3, 1)
    rig.put(0x1800, 6, 4, 1)
    rig.put(0x1800, 1, 0x185, 4)
    rig.hear(START)
    found = [counter for counter in (2, 3, 4, 5, 6, 7, 8, 9, 10, 1, 2) if rig.hear(f"080#{counter:02X}")]
    assert found == [4, 7, 10]


def test_what_a_profile_cannot_tell_now_is_as_it_was_set(rig: Rig) -> None:
    rig.hear(START)
    rig.application.services.set_value(TICKS.index, 0, 77)
    rig.application.read_fails = True
    assert rig.hear("185#R6") == ["185#4D0000000000"]
    assert rig.upload(TICKS.index) == AbortCode.HARDWARE


def test_changed_while_operational(rig: Rig) -> None:
    rig.hear(START)
    rig.put(0x1800, 1, 0x8000_0185, 4)
    rig.application.services.changed(TICKS.index, 0)
    assert rig.run(3) == []
    rig.put(0x1800, 1, 0x1A5, 4)
    rig.application.services.changed(TICKS.index, 0)
    assert rig.run(4) == ["1A5#030000000000"]


# ---- receive PDOs ----


def test_the_application_sees_all_values_of_a_pdo_together(rig: Rig) -> None:
    seen = []
    write = rig.application.write

    def look(index: int, subindex: int, value: int, now_ns: int) -> None:
        seen.append(rig.node.value(TORQUE.index, 0))
        write(index, subindex, value, now_ns)

    rig.application.write = look  # type: ignore[method-assign,assignment]
    rig.map(0x1600, [POSITION, TORQUE])
    rig.hear(START, "205#010000000700")
    assert seen == [7, 7]
    assert rig.told("write") == [("write", 0x2009, 0, 1), ("write", 0x2003, 0, 7)]


def test_order_at_sync(rig: Rig) -> None:
    rig.put(0x1400, 2, 1, 1)
    rig.put(0x1800, 2, 1, 1)
    rig.hear(START, "205#FFFFFFFF0300")
    rig.told()
    assert rig.hear(SYNC) == ["185#010000000300"]
    assert rig.told() == [("write", 0x2009, 0, -1), ("write", 0x2003, 0, 3), ("synced",)]
    assert rig.hear(SYNC) == ["185#010000000300"]
    assert rig.told() == [("synced",)]


def test_what_is_received_is_forgotten_with_the_state(rig: Rig) -> None:
    rig.put(0x1400, 2, 0, 1)
    rig.hear(START, "205#FFFFFFFF0300", "000#8005", START)
    rig.told()
    rig.hear(SYNC)
    assert rig.told() == [("synced",)]


def test_what_is_received_is_forgotten_with_the_mapping(rig: Rig) -> None:
    rig.put(0x1400, 2, 0, 1)
    rig.hear(START, "205#FFFFFFFF0300")
    rig.map(0x1600, [POSITION])
    rig.told()
    rig.hear(SYNC)
    assert rig.told() == [("synced",)]


def test_window_of_sync(rig: Rig) -> None:
    rig.put(0x1400, 2, 1, 1)
    rig.put(0x1007, 0, 2000, 4)
    rig.hear(START, SYNC)
    rig.run(3)
    rig.hear("205#010000000100")
    rig.run(3.1)
    rig.hear("205#020000000200")  # too late
    rig.hear(SYNC)
    assert number(rig, 0x2009) == 1


def test_time_out_of_an_rpdo(rig: Rig) -> None:
    rig.put(0x1400, 5, 10, 2)
    rig.hear(START)
    assert rig.run(50) == []  # from the first one on
    rig.hear("205#010000000100")
    assert rig.run(59) == []
    assert rig.run(80) == ["085#5082110100000000"]
    assert rig.hear("205#010000000100") == ["085#0000000000000000"]
    assert rig.run(85) == []
    assert rig.hear("000#8005") == []
    assert rig.run(200) == []


def test_a_value_that_is_refused_leaves_the_others(rig: Rig) -> None:
    rig.map(0x1600, [entry(0x2006), entry(0x2002, 1), entry(0x2007)])
    rig.hear(START, "205#0D 07 0000C07F")  # the last is no number
    assert (number(rig, 0x2006), number(rig, 0x2002, 1)) == (0, 7)
    assert rig.node.value(0x2007, 0) == 1.5
    rig.hear("205#0C 08 00004040")
    assert (number(rig, 0x2006), number(rig, 0x2002, 1), rig.node.value(0x2007, 0)) == (12, 8, 3.0)


def test_dummies_and_write_only_entries(rig: Rig) -> None:
    rig.map(0x1600, [0x0006_0010, entry(0x2004), 0x0002_0008])
    rig.hear(START)
    rig.told()
    rig.hear("205#FFFF 78563412 FF")
    assert rig.told() == [("write", 0x2004, 0, 0x1234_5678)]


def test_two_rpdos_with_one_identifier(rig: Rig) -> None:
    rig.map(0x1601, [TORQUE, 0x0007_0020])
    rig.put(0x1401, 1, 0x8000_0305, 4)
    rig.put(0x1401, 1, 0x205, 4)
    rig.hear(START, "205#0A0000000B00")
    assert (number(rig, 0x2009), number(rig, 0x2003)) == (10, 10)


def test_synchronous_ones_of_an_unused_sync(rig: Rig) -> None:
    rig.put(0x1005, 0, 0x90, 4)
    rig.put(0x1400, 2, 240, 1)
    rig.hear(START, "205#050000000000", SYNC)
    assert number(rig, 0x2009) == 0
    rig.hear("090#")
    assert number(rig, 0x2009) == 5


# ---- parameters ----

_IN_USE = AbortCode.NOT_NOW


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x1600, 0, b"\0", _IN_USE),
        (0x1600, 1, bytes(4), _IN_USE),
        (0x1A00, 0, b"\0", _IN_USE),
        (0x1400, 1, (0x206).to_bytes(4, "little"), _IN_USE),
        (0x1800, 1, (0x186).to_bytes(4, "little"), _IN_USE),
        (0x1800, 3, b"\1\0", _IN_USE),
        (0x1800, 6, b"\1", _IN_USE),
        (0x1800, 6, b"\xf1", AbortCode.TOO_HIGH),
        (0x1400, 1, (0x2000_0205).to_bytes(4, "little"), AbortCode.VALUE),
        (0x1400, 1, (0x605).to_bytes(4, "little"), AbortCode.VALUE),
        (0x1400, 1, (0).to_bytes(4, "little"), AbortCode.VALUE),
        (0x1400, 1, (0x800).to_bytes(4, "little"), AbortCode.VALUE),
        (0x1400, 2, b"\xf1", AbortCode.VALUE),
        (0x1400, 2, b"\xfd", AbortCode.VALUE),
        (0x1800, 2, b"\xfb", AbortCode.VALUE),
        (0x1400, 3, b"\0\0", AbortCode.NO_SUBINDEX),
        (0x1800, 4, b"\0", AbortCode.NO_SUBINDEX),
        (0x1404, 1, bytes(4), AbortCode.NO_OBJECT),
        (0x1604, 0, b"\0", AbortCode.NO_OBJECT),
        (0x1600, 9, bytes(4), AbortCode.NO_SUBINDEX),
        (0x1800, 0, b"\6", AbortCode.READ_ONLY),
    ],
)
def test_parameters_that_are_refused(rig: Rig, index: int, subindex: int, data: bytes, code: int) -> None:
    before = rig.upload(index, subindex)
    assert rig.download(index, subindex, data) == code
    assert rig.upload(index, subindex) == before


@pytest.mark.parametrize(
    ("index", "value", "code"),
    [
        (0x1600, 0x2999_0008, AbortCode.NO_OBJECT),
        (0x1600, 0x2002_0908, AbortCode.NO_SUBINDEX),
        (0x1600, 0x200B_0008, AbortCode.NOT_MAPPABLE),
        (0x1600, 0x2005_0020, AbortCode.NOT_MAPPABLE),  # the device writes it
        (0x1A00, 0x2004_0020, AbortCode.NOT_MAPPABLE),  # nobody can read it
        (0x1600, 0x2000_0028, AbortCode.NOT_MAPPABLE),
        (0x1600, 0x2009_0010, AbortCode.NOT_MAPPABLE),  # half of it
        (0x1A00, 0x0005_0008, AbortCode.NO_OBJECT),  # a dummy to send
        (0x1600, 0x0001_0001, AbortCode.NO_OBJECT),  # a dummy of a bit
        (0x1A00, 0x1018_0120, AbortCode.NOT_MAPPABLE),
    ],
)
def test_what_cannot_be_mapped(rig: Rig, index: int, value: int, code: int) -> None:
    rig.put(index - 0x200, 1, 0x8000_0185, 4)
    rig.put(index, 0, 0, 1)
    assert rig.download(index, 1, value.to_bytes(4, "little")) == code


def test_the_procedure_of_mapping(rig: Rig) -> None:
    rig.put(0x1400, 1, 0x8000_0205, 4)
    assert rig.download(0x1600, 1, bytes(4)) == AbortCode.NOT_NOW  # sub-index 0 first
    rig.put(0x1600, 0, 0, 1)
    for at in range(3):
        rig.put(0x1600, 1 + at, 0x2009_0020, 4)
    rig.put(0x1600, 4, 0, 4)
    assert rig.download(0x1600, 0, b"\3") == AbortCode.PDO_LENGTH
    assert rig.download(0x1600, 0, b"\x09") == AbortCode.TOO_HIGH
    rig.put(0x1600, 0, 2, 1)
    rig.put(0x1600, 0, 0, 1)
    rig.put(0x1600, 2, 0, 4)
    assert rig.download(0x1600, 0, b"\2") == AbortCode.NO_OBJECT  # a gap
    rig.put(0x1600, 0, 1, 1)
    rig.put(0x1400, 1, 0x205, 4)
    rig.hear(START, "205#07000000")
    assert number(rig, 0x2009) == 7


def test_eight_bytes_of_all_types(rig: Rig) -> None:
    rig.map(0x1600, [entry(0x2008)])
    rig.map(0x1A00, [entry(0x2008)])
    rig.map(0x1A01, [entry(0x2002, 1), entry(0x2007), entry(0x2006), TORQUE])
    rig.hear(START, "205#0102030405060788")
    assert rig.hear("185#R8") == ["185#0102030405060788"]
    assert rig.hear("285#R8") == ["285#000000C03F000000"]
