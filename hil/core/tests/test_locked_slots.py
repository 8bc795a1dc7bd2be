"""Only open axes are locked in memory: those of the start, and those that come later."""

import re
from pathlib import Path

import pytest

from hil.core import Core
from hil.vocab.axis_plan import AXIS_PARAMETERS, AxisPlan

PARAMETERS = dict.fromkeys(AXIS_PARAMETERS["mechaduino"], 1.0)  # any: none of them moves
SLOT_KiB = (86, 100)
"""An axis with its table of 64 KiB and a group with its ring of 24 KiB, and pages that they share."""


def locked_KiB() -> int:
    return int(re.findall(r"VmLck:\s+(\d+)", Path("/proc/self/status").read_text())[0])


def test_axes_are_locked_when_they_are_opened() -> None:
    core = Core(100)
    core.open_axis(core.native.group_open(0), AxisPlan(PARAMETERS))
    before = locked_KiB()
    core.native.rt_start(1_000_000, 1.0, 1, -1)
    try:
        if core.native.rt_stats()["lock_errno"]:
            pytest.skip("locking memory is not permitted here")
        started = locked_KiB()
        assert started - before < 50 * SLOT_KiB[0]
        for _ in range(10):
            core.open_axis(core.native.group_open(0), AxisPlan(PARAMETERS))
        assert SLOT_KiB[0] <= (locked_KiB() - started) / 10 <= SLOT_KiB[1]
    finally:
        core.native.rt_stop()
