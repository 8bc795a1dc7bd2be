"""Axes in status and state: which angle is which, and 0 for what is as good as 0."""

import io
from typing import Any

import pytest
from rich.console import Console

from hil.cli.bench.views import field_lines, status_view
from hil.cli.framework.shown_words import fixed, shown_number

COUNTERS = ("rx_bytes", "tx_bytes", "dropped_bytes", "overrun_bytes", "clients")
SERVO = {"position_deg": 367.15, "velocity_rpm": 4.08e-103, "mode": 120, "loop_on": 1, "yw": 359.96}
STEPPER = {"position_deg": -1e-9, "velocity_rpm": -0.01, "motion_state": 2, "commanded_deg": 0.9, "pulses": 1}
REAL = {"position_deg": 12.5, "velocity_rpm": None, "enabled": 1, "commanded_deg": 13.0}


def status(**shots: Any) -> dict[str, Any]:
    rows = [
        dict.fromkeys(COUNTERS, 0)
        | {"device": name, "hardware": "1", "address": "x", "snapshot": shot, "snapshots": {}}
        | {"failed": None, "port_failure": None, "flash": "ok", "note": None}
        for name, shot in shots.items()
    ]
    numbers = dict.fromkeys(
        ("pid", "sim_ns", "speed", "rate_hz", "ticks", "missed", "elapsed_ns", "overruns"), 1
    )
    lists = {name: [] for name in ("segments", "buses", "switches", "faults", "runs", "wake_latency", "lag")}
    return {
        "bench": "b",
        "devices": rows,
        "health": {"state": "ok", "late_ms": 0.0, "problems": []},
        "bridges": {},
        "echoes": {},
        "rt_line": "",
        **numbers,
        **lists,
    }


def printed(view: Any) -> list[str]:
    out = io.StringIO()
    Console(file=out, width=80).print(view)
    return out.getvalue().splitlines()


def test_the_status_has_the_shafts_angle_and_the_boards() -> None:
    off = SERVO | {"loop_on": 0}
    lines = printed(status_view(status(m1=SERVO, m2=off, s1=STEPPER, r1=REAL, none=None)))
    at = next(at for at, line in enumerate(lines) if line.startswith(" device"))
    assert lines[at - 1].split() == ["shaft", "board"]
    assert [line.split()[5:] for line in lines[at + 1 : at + 6]] == [
        ["367.15", "359.96", "0.0", "x", "ok"],
        ["367.15", "-", "0.0", "x", "off", "ok"],
        ["0.00", "0.90", "0.0", "cruise", "ok"],
        ["-", "12.50", "-", "real", "ok"],
        ["-", "-", "-", "-", "ok"],
    ]


def test_a_door_is_red_only_where_it_is_open_to_all() -> None:
    door = dict.fromkeys(("links", "commands", "rejected", "dropped"), 0) | {"listen": ["x"], "connect": []}
    doors = {
        "metrics": door | {"root": "a", "insecure": False},
        "zenoh": door | {"root": "b", "insecure": True},
    }
    out = io.StringIO()
    console = Console(file=out, width=200, force_terminal=True, color_system="standard")
    console.print(status_view(status(m1=SERVO) | {"bridges": doors}))
    healthy, open_to_all = out.getvalue().splitlines()[-2:]
    assert healthy == "metrics: a at x: 0 links, 0 commands, 0 rejected"
    assert "\x1b[31mzenoh: b at x: " in open_to_all


@pytest.mark.parametrize("far_deg", [-2_452_127.14, 60_000_000.0])
def test_far_angles_fit_80_columns(far_deg: float) -> None:
    dragged = SERVO | {"position_deg": far_deg, "velocity_rpm": -10_000.0, "loop_on": 0}
    lines = printed(status_view(status(m1=dragged)))
    assert any(f"{far_deg:.2f}" in line and "-10000.0" in line for line in lines)


def test_the_state_says_which_angle_is_which() -> None:
    *_, meanings = field_lines({"position_deg": 367.15, "r": 0.0, "yw": 359.96})
    assert meanings.splitlines() == [
        "",
        "position_deg: the shaft's angle, from the encoder's count 0 or `hil zero`",
        "r, y, yw: the board's own angles, by its calibration",
    ]
    lines = "\n".join(field_lines(STEPPER))
    assert "commanded_deg: the angle that the board has the shaft turn to, from the same zero" in lines
    assert "position_deg, commanded_deg: the drive's own angles" in "\n".join(field_lines(REAL))


def test_the_state_has_words_and_each_unit_once() -> None:
    float32 = 0.20000000298023224
    lines = field_lines({"velocity_rpm": 5.5, "mode": 104, "r": 1 / 3, "pKi": float32, "vLPF": 100.0})
    assert [line.split(maxsplit=1) for line in lines] == [
        ["velocity_rpm", "5.5"],
        ["mode", "h (hybrid)"],
        ["r", "0.33333333 deg"],
        ["pKi", "0.2"],
        ["vLPF", "100 Hz"],
    ]
    assert "mode  none" in field_lines({"mode": 0})
    assert "motion_state   cruise" in "\n".join(field_lines(STEPPER))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (4.08e-103, "0"),
        (-4.9e-17, "0"),
        (-0.0, "0"),
        (0.0, "0"),
        (1e-11, "1e-11"),
        (367.15, "367.15"),
        (-1.5, "-1.5"),
        (16384.0, "16384"),
        (591613357800.0, "591613357800"),
        (1e300, "1e+300"),
        (float("inf"), "inf"),
        (1 / 3, "0.3333333333"),
        (None, "-"),
    ],
)
def test_dust_is_0(value: float | None, text: str) -> None:
    assert shown_number(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(-0.004, "0.00"), (-0.005001, "-0.01"), (359.996, "360.00"), (None, "-"), (2, "2.00")]
)
def test_a_0_has_no_sign(value: float | None, text: str) -> None:
    assert fixed(value, 2) == text
