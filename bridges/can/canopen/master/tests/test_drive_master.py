"""What a master makes of a drive: its state machine, its units, its process data, its life: pure."""

import pytest

from bridges.can.canopen.cia402_words import DriveState, has_fault, mode_bit, state_of, towards_enabled
from bridges.can.canopen.master.drive_state import EmergencyLog, emergency_text, reading_of
from bridges.can.canopen.master.drive_units import DriveUnits, GivenUnits, UnitsUnknown, units_of
from bridges.can.canopen.master.greeting import (
    DriveKnown,
    GreetingPause,
    GreetSpec,
    Nmt,
    Unfit,
    greet,
    interpolation_time,
    sync_period_ns,
)
from bridges.can.canopen.master.node_watch import HEARTBEAT_NS, MISSING, NodeWatch
from bridges.can.canopen.master.process_data import TOLD, SyncBeat, mapping_writes, packed_target, values_in
from bridges.can.canopen.master.sdo_transfer import SdoTransfer, TransferAborted

MS = 1_000_000
AS_TOLD = GivenUnits()


# ---- state machine ----


@pytest.mark.parametrize(
    ("statusword", "state"),
    [
        (0x0000, DriveState.NOT_READY),
        (0x0250, DriveState.SWITCH_ON_DISABLED),
        (0x0231, DriveState.READY),
        (0x0233, DriveState.SWITCHED_ON),
        (0x1637, DriveState.OPERATION_ENABLED),
        (0x0217, DriveState.QUICK_STOP),
        (0x021F, DriveState.FAULT_REACTION),
        (0x0238, DriveState.FAULT),
        (0x0005, DriveState.UNKNOWN),
    ],
)
def test_states_are_those_of_the_table(statusword: int, state: DriveState) -> None:
    assert state_of(statusword) is state
    assert has_fault(statusword) == (state in (DriveState.FAULT, DriveState.FAULT_REACTION))


def test_the_walk_to_enabled_goes_round_no_fault() -> None:
    walk = (DriveState.SWITCH_ON_DISABLED, DriveState.READY, DriveState.SWITCHED_ON)
    assert [towards_enabled(state) for state in walk] == [0x06, 0x07, 0x0F]
    assert towards_enabled(DriveState.FAULT) is None
    assert towards_enabled(DriveState.NOT_READY) is None


# ---- units ----


@pytest.mark.parametrize(
    ("objects", "given", "per_deg", "per_rpm", "per_rpm_per_s"),
    [
        ({(0x608F, 1): 36000, (0x608F, 2): 1}, AS_TOLD, 100, 600, 600),
        ({(0x608F, 1): 3600, (0x6091, 1): 10, (0x6091, 2): 1}, AS_TOLD, 100, 600, 600),
        ({(0x608F, 1): 16384, (0x6092, 1): 360000, (0x6092, 2): 1}, AS_TOLD, 1000, 6000, 6000),
        ({(0x608F, 1): 36000, (0x6092, 1): 1, (0x6092, 2): 1}, AS_TOLD, 100, 600, 600),
        ({(0x60A8, 0): 0xFF41_0000, (0x60A9, 0): 0x00B4_4700}, AS_TOLD, 10, 1, 1),
        (
            {(0x608F, 1): 36000, (0x60A9, 0): 0xFFB4_4700, (0x60AA, 0): 0x00B4_4703},
            AS_TOLD,
            *(100, 10, 1),
        ),
        ({(0x608F, 1): 36000}, GivenUnits(360_000, 10), 1000, 10, 10),
        ({}, GivenUnits(360_000, 10, 2), 1000, 10, 2),
    ],
)
def test_units_are_those_of_the_drive_or_those_that_are_given(
    objects: dict[tuple[int, int], int],
    given: GivenUnits,
    per_deg: float,
    per_rpm: float,
    per_rpm_per_s: float,
) -> None:
    units = units_of(objects, given)
    assert units.position_per_deg == pytest.approx(per_deg)
    assert units.velocity_per_rpm == pytest.approx(per_rpm)
    assert units.acceleration_per_rpm_per_s == pytest.approx(per_rpm_per_s)


def test_a_drive_that_does_not_say_what_a_turn_is_is_not_used() -> None:
    for objects in ({}, {(0x608F, 1): 0, (0x608F, 2): 1}, {(0x6092, 1): 1, (0x6092, 2): 0}):
        with pytest.raises(UnitsUnknown, match="how many units a turn has"):
            units_of(objects, AS_TOLD)


def test_what_a_drive_cannot_hold_is_refused() -> None:
    units = DriveUnits(1000, 6000, 6000)
    assert units.position(-0.0004) == 0
    assert units.position(2_147_483.647) == 2**31 - 1
    with pytest.raises(ValueError, match="cannot hold"):
        units.position(2_147_483.648)
    assert units.velocity(1e-9) == 1
    with pytest.raises(ValueError, match="rpm"):
        units.velocity(1e6)


# ---- process data ----


def test_process_data_are_eight_bytes_at_most_and_read_as_they_are_mapped() -> None:
    assert [sum(each.bits for each in objects) // 8 for objects in TOLD] == [7, 8]
    data = bytes.fromhex("3702") + (-5).to_bytes(4, "little", signed=True) + b"\x08"
    assert values_in(TOLD[0], data) == {"statusword": 0x237, "position": -5, "mode": 8}
    assert values_in(TOLD[0], data + b"\0") is not None
    assert values_in(TOLD[0], data[:6]) is None
    assert packed_target(-1) == b"\xff" * 4


def test_set_points_are_evenly_spaced_unless_a_sync_is_much_too_late() -> None:
    beat = SyncBeat()
    times = [beat.next(now_ns * MS, 20 * MS) // MS for now_ns in (1000, 1021, 1039, 1065, 1080, 1140, 1160)]
    assert times == [1000, 1020, 1040, 1060, 1080, 1140, 1160]
    assert beat.next(1179 * MS, 20 * MS) == 1180 * MS
    assert beat.synced_ns == 1179 * MS


def test_a_pdo_is_switched_off_before_it_is_mapped() -> None:
    writes = [(each.index, each.subindex, each.value) for each in mapping_writes(0x185, 0, TOLD[0][:2], 1)]
    assert writes == [
        (0x1800, 1, 0x8000_0185),
        (0x1800, 2, 1),
        (0x1A00, 0, 0),
        (0x1A00, 1, 0x6041_0010),
        (0x1A00, 2, 0x6064_0020),
        (0x1A00, 0, 2),
        (0x1800, 1, 0x185),
    ]


def test_a_reading_says_what_the_objects_mean() -> None:
    units = DriveUnits(100, 600, 600, current_A=0.002)
    raw = {"statusword": 0x0637, "position": 9000, "mode": 1, "velocity": 6000, "current": -250, "error": 0}
    reading = reading_of(raw, units, 7)
    assert reading.at_ns == 7
    assert (reading.values["position_deg"], reading.values["velocity_rpm"]) == (90, 10)
    assert (reading.values["current_A"], reading.values["fault_code"]) == (-0.5, 0)
    assert (reading.values["statusword"], reading.values["mode"]) == (0x637, 1)
    assert reading.bits == {"status.enabled": True, "status.fault": False, "status.moving": True}
    assert reading_of({"statusword": 0x0237, "position": 0, "mode": 1}, units, 0).bits["status.moving"]
    assert not reading_of({"statusword": 0x0637, "position": 0, "mode": 1}, units, 0).bits["status.moving"]


def test_emergencies_are_said_in_words() -> None:
    assert emergency_text(bytes.fromhex("1186210102000000")) == (
        "8611h (following error), maker's bytes 01 02 00 00 00"
    )
    assert emergency_text(bytes(8)) == ""
    assert emergency_text(bytes(7)) is None
    seen = EmergencyLog()
    message = bytes.fromhex("1081110000000000")
    said = [seen.hear(each) for each in (message, message, bytes(5), bytes(8))]
    assert said == ["emergency 8110h (CAN overrun, frames were lost)", None, None, "its emergency is over"]
    assert (seen.count, seen.text) == (3, None)


# ---- life ----


def test_a_node_is_lost_without_heartbeats_and_by_its_boot_up() -> None:
    watch = NodeWatch()
    assert watch.loss(10**12) is None
    watch.begin(0, "heartbeat")
    for at in range(1, 6):
        assert not watch.hear(b"\x05", at * HEARTBEAT_NS)
        assert watch.loss(at * HEARTBEAT_NS) is None
    late_ns = (5 + MISSING) * HEARTBEAT_NS
    assert watch.loss(late_ns) is None
    assert watch.loss(late_ns + MS) == "no heartbeat for 301 ms"
    watch.begin(late_ns, "heartbeat")
    assert watch.hear(b"\x00", late_ns + MS)
    assert "boot-up" in (watch.loss(late_ns + MS) or "")
    watch.end()
    assert watch.loss(10**12) is None


def test_a_node_that_is_stopped_is_lost_but_not_by_what_it_said_before_its_start() -> None:
    watch = NodeWatch()
    watch.begin(0, "heartbeat")
    watch.hear(b"\x7f", 10 * MS)
    assert watch.loss(10 * MS) is None
    watch.hear(b"\x04", 400 * MS)
    assert watch.loss(400 * MS) == "somebody took it out of operation: it is stopped"


def test_guarding_wants_its_toggle_bit() -> None:
    watch = NodeWatch()
    watch.begin(0, "guarding")
    for at in range(1, 5):
        watch.hear(bytes([0x05 | (at & 1) << 7]), at * HEARTBEAT_NS)
    assert watch.loss(4 * HEARTBEAT_NS) is None
    for at in range(5, 9):
        watch.hear(b"\x05", at * HEARTBEAT_NS)
    assert "no answer to guarding for" in (watch.loss(8 * HEARTBEAT_NS) or "")
    watch.begin(0, "")
    assert watch.loss(10**12) is None


# ---- greeting ----


def greeted(
    objects: dict[tuple[int, int], bytes], refused: frozenset[int] = frozenset(), **spec: int
) -> tuple[DriveKnown, list[object]]:
    """Greet a drive that has these objects. Answers what is known of it, and all writes and commands."""
    steps, done = greet(GreetSpec(node=5, sync_ns=20 * MS, **spec)), list[object]()
    step = next(steps)
    while True:
        try:
            if not isinstance(step, SdoTransfer):
                done += [step] if isinstance(step, Nmt) else []
                assert isinstance(step, Nmt | GreetingPause)
                step = steps.send(b"")
            elif (step.index, step.subindex) not in objects or (step.data and step.index in refused):
                step = steps.throw(TransferAborted(0x0602_0000, str(step)))
            elif step.data is None:
                step = steps.send(objects[step.index, step.subindex])
            else:
                done.append((step.index, step.subindex, int.from_bytes(step.data, "little")))
                step = steps.send(step.data)
        except StopIteration as end:
            return end.value, done


def number(value: int, size: int = 4) -> bytes:
    return value.to_bytes(size, "little")


DRIVE = {
    (0x1000, 0): number(0x2_0192),
    (0x1008, 0): b"A drive\0\1",
    (0x1018, 1): number(7),
    (0x1016, 1): number(0),
    (0x1017, 0): number(0, 2),
    (0x6502, 0): number(mode_bit(1) | mode_bit(8)),
    (0x608F, 1): number(36000),
    (0x60C2, 1): number(1, 1),
    (0x60C2, 2): number(1, 1),
    (0x6041, 0): number(0, 2),
    (0x6064, 0): number(0),
    (0x606C, 0): number(0),
    **{(0x1800 + n, sub): number(0x4000_0000) for n in range(4) for sub in (1, 2)},
    **{(0x1A00 + n, sub): number(0) for n in range(4) for sub in range(9)},
    **{(base, sub): number(0) for base in (0x1400, 0x1600) for sub in range(9)},
}


def test_a_greeting_maps_what_the_drive_has() -> None:
    known, done = greeted(DRIVE, master=127)
    assert (known.name, known.identity) == ("A drive", {"vendor": 7})
    assert [[each.field for each in objects] for objects in known.told] == [
        ["statusword", "position"],
        ["velocity"],
    ]
    assert known.follows_paths
    assert known.watches
    assert [each for each in done if isinstance(each, Nmt)] == [Nmt(0x80), Nmt(1)]
    assert (0x1016, 1, 127 << 16 | 500) in done
    assert (0x60C2, 1, 20) in done
    assert (0x60C2, 2, 0xFD) in done
    assert (0x1800, 1, 0x4000_0185) in done  # bit 30 as the drive has it
    assert (0x1802, 1, 0x8000_0385) in done  # those that are not used are off


def test_a_drive_that_refuses_is_read_by_sdo() -> None:
    known, _ = greeted(DRIVE, refused=frozenset({0x1A00, 0x1017}))
    assert (known.told, known.follows_paths, known.error_control) == ((), False, "")
    assert [each.field for each in known.read] == ["statusword", "position", "velocity"]
    known, _ = greeted(DRIVE | {(0x100C, 0): b"", (0x100D, 0): b""}, refused=frozenset({0x1017, 0x1600}))
    assert known.error_control == "guarding"
    assert known.told
    assert not known.follows_paths


def test_what_is_no_drive_is_refused() -> None:
    for change, why in (
        ({(0x1000, 0): number(401)}, "device type is 00000191h"),
        ({(0x6502, 0): number(mode_bit(3))}, "neither profile position"),
    ):
        with pytest.raises(Unfit, match=why):
            greeted(DRIVE | change)
    without = {key: value for key, value in DRIVE.items() if key != (0x6064, 0)}
    with pytest.raises(Unfit, match=r"it has no position \(6064h\)"):
        greeted(without)


def test_sync_has_a_period_that_60c2_can_say() -> None:
    for wanted_ns, period_ns, said in (
        (20 * MS, 20 * MS, (20, -3)),
        (5 * MS, 5 * MS, (5, -3)),
        (16_666_667, 16_700_000, (167, -4)),
        (1000 * MS, 255 * MS, (255, -3)),
        (33_333_333, 33 * MS, (33, -3)),
    ):
        assert sync_period_ns(wanted_ns) == period_ns
        assert interpolation_time(period_ns) == said
