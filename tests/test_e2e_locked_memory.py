"""Memory that the core keeps from being paged out: LimitMEMLOCK of the units follows from it."""

import re
from pathlib import Path

import pytest
from e2e_support import Place, config

LIMITS_KiB = {"mechaduino": (64, 17 * 1024, 64), "sac": (11, 4 * 1024 + 128, 24)}
"""Limits by profile: the least for each axis (a Mechaduino's lookup table, a SAC's motion engine), the most
for the code and the stack, and the most for each axis. 252 SACs, a full line, are below 10 MiB."""


@pytest.mark.parametrize("profile", LIMITS_KiB)
@pytest.mark.parametrize("axes", [1, 32, 252, 450])
def test_locked_memory_is_bounded(place: Place, axes: int, profile: str) -> None:
    device = {"profile": profile, "port": "tcp", "flash": {}}
    server = place.serve(config(speed=1, devices={f"m{i}": device for i in range(axes)}))
    if "no locked memory" in server.ask("status")["rt_line"]:
        pytest.skip("locking memory is not permitted here")
    (locked,) = re.findall(r"VmLck:\s+(\d+) kB", Path(f"/proc/{server.pid}/status").read_text())
    least_KiB, base_KiB, each_KiB = LIMITS_KiB[profile]
    assert axes * least_KiB < int(locked) <= base_KiB + axes * each_KiB
