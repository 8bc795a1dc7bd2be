"""Anything may be written at any time: it is taken or refused by the book, and the drive lives on.

``HIL_FUZZ`` sets how much is tried: a hundredth of it in steps (1,000 rounds of 100 in ``make fuzz``),
``HIL_FUZZ_SEED`` where it starts.
"""

import os
import random

import pytest
from drive_rig import STEPPER, DriveRig, SimpleAxis, Switch

from bridges.can.canopen.node.application import Access, DataType, SdoAbort

STEPS = 100
ROUNDS = int(os.environ.get("HIL_FUZZ", "600000")) // STEPS // 100
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
CODES = {0x0609_0030, 0x0609_0031, 0x0609_0032, 0x0609_0036, 0x0800_0022, 0x0601_0002}
RANGES = {
    DataType.INTEGER8: (-(2**7), 2**7 - 1),
    DataType.INTEGER16: (-(2**15), 2**15 - 1),
    DataType.INTEGER32: (-(2**31), 2**31 - 1),
    DataType.UNSIGNED8: (0, 2**8 - 1),
    DataType.UNSIGNED16: (0, 2**16 - 1),
    DataType.UNSIGNED32: (0, 2**32 - 1),
}
SWITCHES: dict[str, Switch] = {
    "home": lambda deg: 100 <= deg <= 110,
    "negative": lambda deg: deg < -500,
    "positive": lambda deg: deg > 500,
}
STATES = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08}
WORDS = (0x00, 0x02, 0x06, 0x07, 0x0F, 0x0F, 0x0F, 0x1F, 0x3F, 0x5F, 0x21F, 0x10F, 0x11F, 0x80, 0x8F)


def value_for(chance: random.Random, data_type: DataType) -> int:
    low, high = RANGES[data_type]
    return chance.choice(
        (low, high, 0, 1, -1, chance.randint(low, high), chance.randint(max(low, -1000), min(high, 1000)))
    )


def step(rig: DriveRig, chance: random.Random) -> None:
    """Do something that a master, a bus or a board may do."""
    kind = chance.randrange(12)
    if kind < 4:
        rig.write(0x6040, chance.choice(WORDS))
    elif kind == 4:
        rig.write(0x6060, chance.choice((1, 3, 4, 6, 8, 9)))
    elif kind == 5:
        rig.write(chance.choice((0x607A, 0x60FF)), chance.randint(-1_000_000, 1_000_000))
    elif kind == 6:
        entry = chance.choice([e for e in rig.drive.entries if e.access is Access.RW and e.index >= 0x2000])
        rig.write(entry.index, value_for(chance, entry.data_type), entry.subindex)
    elif kind < 10:
        rig.sync()
        rig.run(chance.choice((0.3, 1, 1, 5)))
    elif kind == 10:
        rig.run(chance.choice((1, 10, 100)))
    else:
        trouble = chance.randrange(6)
        rig.axis.off_by_deg = chance.choice((0.0, 0.0, 40.0))
        rig.axis.refuses = chance.choice(("", "", "", "follow", "stop", "enable", "disable", "torque"))
        if trouble == 0:
            rig.axis.fault_code = 0x7305
        elif trouble == 1:
            rig.drive.lost(chance.choice(("heartbeat", "guarding", "bus-off")), rig.now_ns)


@pytest.mark.parametrize("is_servo", [True, False], ids=["servo", "stepper"])
def test_a_drive_takes_whatever_comes(is_servo: bool) -> None:
    for number in range(ROUNDS):
        chance = random.Random(SEED * 1_000_000 + number)
        if is_servo:
            axis = SimpleAxis(switches=SWITCHES)
        else:
            axis = SimpleAxis(verbs=STEPPER, follows_paths=False, switches=SWITCHES, index_deg=None)
        rig = DriveRig(axis)
        for _ in range(STEPS):
            try:
                step(rig, chance)
            except SdoAbort as abort:
                if abort.code not in CODES:
                    raise
            except KeyError:
                if is_servo:
                    raise  # a stepper has not all objects
            status = rig.status
            assert status & (0x4F if status & 0x4F in (0, 0x40, 0x08, 0x0F) else 0x6F) in STATES
            for entry in rig.drive.entries:
                if entry.is_live:
                    low, high = RANGES[entry.data_type]
                    assert low <= rig.read(entry.index) <= high
