"""Path that axes follow for ``--plot``: zeros of shafts are not in it."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hil.cli.framework.ask import ANY_BENCH, BenchOptions
from hil.cli.gcode.gcode_plot import FollowedAxes, begin_of
from hil.toolpath.machine import parse_machine

LIMITS = "min_mm: -60, max_mm: 60, velocity_mm_per_min: 6000, acceleration_mm_per_s2: 1000"
MACHINE = f"""machine: plotter
axes:
  x: {{axis: m1, deg_per_mm: 9, {LIMITS}}}
  y: {{axis: s1, deg_per_mm: 9, is_reversed: true, {LIMITS}}}
"""
BOARD = {"m1": "yw", "s1": "commanded_deg"}
WAYS_DEG = [0.0, 4.5, 9.0]


class TwoAxes:
    """Control socket of a bench whose axes move by ``WAYS_DEG`` from 18 deg by their boards' zeros."""

    def __init__(self, zeroed_deg: float) -> None:
        self._zeroed_deg = zeroed_deg
        self._watched: list[str] = []

    def ask(self, _: Path, verb: str, **given: Any) -> Any:
        if verb == "state":
            return {"position_deg": 18.0 - self._zeroed_deg, BOARD[given["device"]]: 18.0, "loop_on": 1}
        if verb == "watch":
            assert given["signals"] == ["position_deg"]
            self._watched.append(given["device"])
            return {"watch": len(self._watched)}
        if verb == "samples":
            rows = [[5 * at, 18.0 + way - self._zeroed_deg] for at, way in enumerate(WAYS_DEG)]
            return {"rows": rows, "lost": 0}
        assert verb == "unwatch"
        return None


@pytest.mark.parametrize("zeroed_deg", [0.0, 287.0, -31.9])
def test_a_zero_of_the_shafts_is_none_of_the_path(
    zeroed_deg: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """`hil zero` moves positions of shafts; set-points stay where the boards have them."""
    bench = TwoAxes(zeroed_deg)
    monkeypatch.setattr("hil.net.control_client.ask", bench.ask)
    monkeypatch.setattr(BenchOptions, "meant", lambda _: SimpleNamespace(socket=tmp_path))
    machine = parse_machine(MACHINE, "plotter.yaml")
    begin = begin_of(machine, ANY_BENCH)
    assert (begin.x, begin.y) == (2.0, -2.0)
    followed = FollowedAxes(machine, ANY_BENCH)
    followed.begin()
    assert [pytest.approx(place) for place in followed.end()] == [(2.0, -2.0), (2.5, -2.5), (3.0, -3.0)]
