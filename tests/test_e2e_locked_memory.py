"""How much memory the core keeps from being paged out: LimitMEMLOCK of the units follows from it."""

import re
from pathlib import Path

import pytest
from e2e_support import Place, config

BASE_KiB = 16 * 1024
TABLE_KiB = 64
"""A Mechaduino's lookup table, of which each axis has one."""


@pytest.mark.parametrize("profile", ["mechaduino", "sac"])
@pytest.mark.parametrize("axes", [1, 32, 252, 450])
def test_locked_memory_is_bounded(place: Place, axes: int, profile: str) -> None:
    device = {"profile": profile, "port": "tcp", "flash": {}}
    server = place.serve(config(speed=1, devices={f"m{i}": device for i in range(axes)}))
    if "no locked memory" in server.ask("status")["rt_line"]:
        pytest.skip("locking memory is not permitted here")
    (locked,) = re.findall(r"VmLck:\s+(\d+) kB", Path(f"/proc/{server.pid}/status").read_text())
    assert axes * TABLE_KiB < int(locked) <= BASE_KiB + axes * TABLE_KiB
