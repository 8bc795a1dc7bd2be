"""The table of objects: it says what the axis can do, and refuses what the drive does not take."""

from collections import defaultdict

import pytest
from drive_rig import STEPPER, DriveRig, SimpleAxis

from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.cia402.drive_entries import modes_of
from bridges.can.canopen.cia402.objects import NAMES
from bridges.can.canopen.node.application import Access, DataType, Entry, SdoAbort

SIZES = {
    DataType.INTEGER8: (-(2**7), 2**7 - 1),
    DataType.INTEGER16: (-(2**15), 2**15 - 1),
    DataType.INTEGER32: (-(2**31), 2**31 - 1),
    DataType.UNSIGNED8: (0, 2**8 - 1),
    DataType.UNSIGNED16: (0, 2**16 - 1),
    DataType.UNSIGNED32: (0, 2**32 - 1),
}
SERVO_RIG = DriveRig()
STEPPER_RIG = DriveRig(SimpleAxis(verbs=STEPPER, follows_paths=False, index_deg=None))
ENTRIES = [
    pytest.param(entry, id=f"{kind}-{entry.index:04X}-{entry.subindex}")
    for kind, rig in (("servo", SERVO_RIG), ("stepper", STEPPER_RIG))
    for entry in rig.drive.entries
    if entry.index >= 0x2000
]
REQUIRED = {
    *(0x603F, 0x6040, 0x6041, 0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007, 0x6060, 0x6061, 0x6062, 0x6063),
    *(0x6064, 0x6065, 0x6066, 0x6067, 0x6068, 0x606B, 0x606C, 0x606D, 0x606E, 0x606F, 0x6070, 0x6071, 0x6072),
    *(0x6075, 0x6076, 0x6077, 0x6078, 0x607A, 0x607C, 0x607D, 0x607E, 0x607F, 0x6080, 0x6081, 0x6083, 0x6084),
    *(0x6085, 0x6086, 0x608F, 0x6091, 0x6092, 0x6096, 0x6097, 0x6098, 0x6099, 0x609A, 0x60C2, 0x60C5, 0x60C6),
    *(0x60F4, 0x60FC, 0x60FD, 0x60FF, 0x6502, 0x67FF),
}


@pytest.mark.parametrize("entry", ENTRIES)
def test_a_default_is_within_its_limits(entry: Entry) -> None:
    low, high = SIZES[entry.data_type]
    low = low if entry.low is None else int(entry.low)
    high = high if entry.high is None else int(entry.high)
    assert SIZES[entry.data_type][0] <= low <= int(entry.default) <= high <= SIZES[entry.data_type][1]
    assert entry.about
    assert entry.name


@pytest.mark.parametrize("rig", [SERVO_RIG, STEPPER_RIG], ids=["servo", "stepper"])
def test_objects_with_sub_indices_have_names_and_counts(rig: DriveRig) -> None:
    by_index: dict[int, list[Entry]] = defaultdict(list)
    for entry in rig.drive.entries:
        if entry.index < 0x2000:
            continue
        by_index[entry.index].append(entry)
    for index, entries in by_index.items():
        assert len({entry.subindex for entry in entries}) == len(entries)
        assert (len(entries) > 1) == (index in rig.drive.names)
        if index in rig.drive.names:
            assert entries[0].default == len(entries) - 1
            assert [entry.subindex for entry in entries] == list(range(len(entries)))
    assert set(rig.drive.names) <= set(NAMES)


def test_a_servo_has_all_of_it() -> None:
    assert {entry.index for entry in SERVO_RIG.drive.entries} >= REQUIRED


def test_a_board_without_paths_says_so() -> None:
    assert modes_of(STEPPER_RIG.axis) == (1, 3, 6)
    assert STEPPER_RIG.read(0x6502) == 0b100101
    assert SERVO_RIG.read(0x6502) == 0b110101101
    assert not {0x60C2, 0x6071, 0x6072, 0x6086} & {entry.index for entry in STEPPER_RIG.drive.entries}
    assert STEPPER_RIG.drive.device_type == STEPPER_RIG.read(0x67FF) == 0x0004_0192
    for mode in (4, 8, 9):
        with pytest.raises(SdoAbort) as refused:
            STEPPER_RIG.write(0x6060, mode)
        assert refused.value.code == 0x0609_0030


@pytest.mark.parametrize("entry", ENTRIES)
def test_every_live_value_can_be_read(entry: Entry) -> None:
    for rig in (SERVO_RIG, STEPPER_RIG):
        if entry.is_live and (entry.index, entry.subindex) in rig.entries:
            low, high = SIZES[entry.data_type]
            assert low <= rig.read(entry.index, entry.subindex) <= high


@pytest.mark.parametrize(
    ("index", "subindex", "value"),
    [
        *((0x6060, 0, mode) for mode in (-1, 0, 2, 5, 7, 10, 127)),
        *((0x605A, 0, 4), (0x6086, 0, 1), (0x6086, 0, 2), (0x607E, 0, 1), (0x607E, 0, 0xBF)),
        *((0x6098, 0, 17), (0x6098, 0, 15), (0x6098, 0, 31), (0x6098, 0, 36)),
        *((0x60C2, 2, -6), (0x60C2, 2, 0)),
    ],
)
def test_a_value_that_means_nothing_is_refused(index: int, subindex: int, value: int) -> None:
    rig = DriveRig()
    if index == 0x60C2:
        rig.write(0x60C2, 99, 1)
    before = rig.read(index, subindex)
    with pytest.raises(SdoAbort) as refused:
        rig.write(index, value, subindex)
    assert refused.value.code == 0x0609_0030
    assert f"{value}" in str(refused.value)
    assert rig.read(index, subindex) == before


@pytest.mark.parametrize("index", [0x6091, 0x6092, 0x6096, 0x6097])
def test_factors_stay_while_operation_is_enabled(index: int) -> None:
    rig = DriveRig()
    rig.enable()
    with pytest.raises(SdoAbort) as refused:
        rig.write(index, 7, 1)
    assert refused.value.code == 0x0800_0022
    rig.control(0x06)
    rig.write(index, 7, 1)


def test_a_limit_below_the_other_is_refused() -> None:
    rig = DriveRig()
    rig.write(0x607D, 100, 2)
    with pytest.raises(SdoAbort) as refused:
        rig.write(0x607D, 101, 1)
    assert refused.value.code == 0x0609_0036
    rig.write(0x607D, -5, 1)
    with pytest.raises(SdoAbort) as refused:
        rig.write(0x607D, -6, 2)
    assert refused.value.code == 0x0609_0036


@pytest.mark.parametrize("entry", [each for each in ENTRIES if each.values[0].access is Access.RW])  # type: ignore[union-attr]
def test_limits_are_taken_in_operation(entry: Entry) -> None:
    """Whatever may be written does no harm, at both ends of what is allowed, in every mode."""
    low, high = SIZES[entry.data_type]
    for value in (
        low if entry.low is None else int(entry.low),
        high if entry.high is None else int(entry.high),
    ):
        for mode in (1, 3, 4, 6, 8, 9):
            rig = DriveRig()
            rig.write(0x6007, 0)
            rig.write(0x6060, mode)
            try:
                if entry.index not in (0x6040, 0x6060):
                    rig.write(entry.index, value, entry.subindex)
            except (SdoAbort, KeyError):
                continue
            rig.enable()
            for _ in range(3):
                rig.control(0x0F, 0x1F)
                if entry.index != 0x60FF:
                    rig.write(0x60FF, 1000)
                if entry.index != 0x607A:
                    rig.write(0x607A, 1000)
                rig.sync()
                rig.run(3)
            assert rig.emergencies in ([], [0xFF02]), entry
            for each in rig.drive.entries:
                if each.is_live:
                    least, most = SIZES[each.data_type]
                    assert least <= rig.read(each.index) <= most


def test_rated_values_are_the_boards() -> None:
    assert (SERVO_RIG.read(0x6075), SERVO_RIG.read(0x6076)) == (2000, 400)
    assert (SERVO_RIG.read(0x608F, 1), SERVO_RIG.read(0x608F, 2)) == (16384, 1)
    assert SERVO_RIG.read(0x6080) == 3000


def test_other_inputs_come_behind_the_switches() -> None:
    rig = DriveRig(
        SimpleAxis(switches={"home": lambda deg: True, "D2": lambda deg: True, "D0": lambda deg: False})
    )
    assert rig.read(0x60FD) == 1 << 2 | 1 << 17


def test_a_position_that_does_not_fit_is_the_nearest_that_does() -> None:
    rig = DriveRig()
    rig.axis.off_by_deg = 1e7
    rig.run(1)
    assert rig.read(0x6064) == 2**31 - 1
    rig.axis.off_by_deg = -1e7
    rig.run(1)
    assert rig.read(0x6064) == -(2**31)


def test_what_is_stored_is_taken_at_power_up() -> None:
    rig = DriveRig()
    rig.kept[0x6060, 0] = 3
    rig.kept[0x6092, 1] = 360
    rig.drive.entered(NmtState.INITIALISING, 0)
    assert rig.read(0x6061) == 3
    rig.axis.off_by_deg = 90.0
    rig.run(1)
    assert rig.read(0x6064) == 90
