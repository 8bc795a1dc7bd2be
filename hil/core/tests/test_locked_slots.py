"""Locked memory of axes: only open axes are locked, those of the start and those that come later."""

import re
from pathlib import Path

import pytest

from hil.core import KINDS, Core
from hil.vocab.axis_plan import AxisPlan

SHARED_KiB = 8
"""Pages that an axis, its law, its group or its ring shares with others, or leaves free."""


def locked_KiB() -> int:
    return int(re.findall(r"VmLck:\s+(\d+)", Path("/proc/self/status").read_text())[0])


def plan(law: str) -> AxisPlan:
    parameters = dict.fromkeys(KINDS[law].parameters, 1.0)  # any: none of them moves
    return AxisPlan(parameters, law=law)


@pytest.mark.parametrize(("law", "least_KiB", "most_KiB"), [("mechaduino", 90, 94), ("sac", 11, 14)])
def test_the_table_of_kinds_says_what_an_axis_needs(law: str, least_KiB: int, most_KiB: int) -> None:
    """64 KiB of a look-up table and a ring of 24 KiB are the Mechaduino's, and no other's."""
    assert least_KiB <= KINDS[law].memory_bytes / 1024 <= most_KiB


@pytest.mark.parametrize("law", KINDS)
def test_axes_are_locked_when_they_are_opened(law: str) -> None:
    own_KiB = KINDS[law].memory_bytes / 1024
    core = Core(100)
    core.open_axis(core.native.group_open(0), plan(law))
    before = locked_KiB()
    core.native.rt_start(1_000_000, 1.0, 1, -1)
    try:
        if core.native.rt_stats()["lock_errno"]:
            pytest.skip("locking memory is not permitted here")
        started = locked_KiB()
        assert started - before < 4096 + 2 * own_KiB
        for _ in range(10):
            core.open_axis(core.native.group_open(0), plan(law))
        assert own_KiB - SHARED_KiB / 2 <= (locked_KiB() - started) / 10 <= own_KiB + SHARED_KiB
    finally:
        core.native.rt_stop()
