"""Watchers get their samples, step responses their figures, and drawings come out."""

import json
import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from hil.core.kinds.mechaduino.kind import KIND as MECHADUINO
from hil.telemetry import Recording, check_signals, other_motion, picture, step_response, text_plot
from hil.telemetry.recording import units_in
from hil.testing import Bench
from hil.wire.step_dir import generate

CONFIG = {"bench": "t", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}


def holding() -> Bench:
    """Bench with its board in position mode, loop on, still."""
    bench = Bench(CONFIG)
    bench.run(ms=4500)
    bench.port("m1").write(b"xy")
    bench.run(ms=500)
    return bench


def second_order(damping: float, interval_ms: float = 0.1) -> Recording:
    """The textbook's step response of 1 rad/ms, from 10 to 30."""
    recording = Recording(("r", "yw"))
    root = math.sqrt(1 - damping**2)
    for i in range(-20, 600):
        t = i * interval_ms
        wave = math.exp(-damping * t) * (math.cos(root * t) + damping / root * math.sin(root * t))
        recording.rows.append(
            (i * interval_ms * 1e6, 30.0 if i >= 0 else 10.0, 30 - 20 * wave if i >= 0 else 10.0)
        )
    return recording


@pytest.mark.parametrize("damping", [0.2, 0.5, 0.7])
def test_the_figures_are_those_of_the_textbook(damping: float) -> None:
    figures = step_response(second_order(damping))
    assert (figures.amplitude, figures.target, figures.at_ns) == (20, 30, 0)
    textbook_pct = 100 * math.exp(-math.pi * damping / math.sqrt(1 - damping**2))
    assert figures.overshoot_pct == pytest.approx(textbook_pct, rel=0.01)
    assert figures.settling_ms is not None
    envelope_ms = -math.log(0.02 * math.sqrt(1 - damping**2)) / damping
    assert envelope_ms - math.pi < figures.settling_ms <= envelope_ms + 0.1
    assert figures.final_error == pytest.approx(0, abs=0.1)


CASES = json.loads(Path(__file__).with_name("step_cases.json").read_text("utf-8"))
"""Steps of which the page computes the same figures: web/tests/step_response.test.ts."""


@pytest.mark.parametrize("case", CASES, ids=[case["about"] for case in CASES])
def test_the_figures_are_those_of_the_page(case: dict[str, Any]) -> None:
    rows = zip(case["at_ms"], case["set_point"], case["position"], strict=True)
    figures = step_response(Recording(("r", "yw"), [(at_ms * 1e6, r, yw) for at_ms, r, yw in rows]))
    for name in ("rise_ms", "overshoot_pct", "settling_ms", "final_error"):
        assert getattr(figures, name) == (pytest.approx(case[name]) if case[name] is not None else None)


def test_what_never_arrives_never_settles() -> None:
    recording = Recording(
        ("r", "yw"), [(i * 1e6, 1.0 if i > 5 else 0.0, 0.5 if i > 5 else 0.0) for i in range(90)]
    )
    figures = step_response(recording)
    assert (figures.rise_ms, figures.settling_ms, figures.final_error) == (None, None, -0.5)
    assert "settled after never" in figures.line("deg")


@pytest.mark.parametrize("rows", [[], [(i, 1.0, 2.0) for i in range(30)], [(0, 0, 0), (1, 1, 0)]])
def test_no_step_is_no_response(rows: list[tuple[float, ...]]) -> None:
    with pytest.raises(ValueError, match="no step of r"):
        step_response(Recording(("r", "yw"), rows))


@pytest.mark.parametrize(
    ("setpoints", "told"),
    [
        ([96.3341] * 9 + [141.33] * 30, None),
        ([-1e6] * 9 + [-1e6 + 45.0625] * 30, None),
        ([96.33] * 9, None),
        ([96.33] * 9 + [96.39] * 30, "r stepped by 0.06 instead of 45.00: something else moves it"),
        ([96.33] * 9 + [141.39] * 30, "r stepped by 45.06 instead of 45.00: something else moves it"),
        ([96.33] * 9 + [96.39] * 9 + [141.33] * 30, "r changed 2 times: another motion is under way"),
    ],
    ids=["typed", "far", "nothing", "a pulse", "a pulse more", "both"],
)
def test_a_step_that_is_not_the_one_asked_for_is_told(setpoints: list[float], told: str | None) -> None:
    rows = [(i * 1e6, r, r) for i, r in enumerate(setpoints)]
    assert other_motion(Recording(("r", "yw"), rows), 45.0) == told


def test_a_step_of_the_twin() -> None:
    bench = holding()
    recording = bench.axis("m1").record(interval_ms=0.25)
    bench.run(ms=50)
    bench.port("m1").write(b"r96.3\n")
    bench.run(ms=400)
    figures = step_response(recording)
    assert figures.amplitude == pytest.approx(90, abs=0.1)
    assert 3 < figures.overshoot_pct < 8
    assert 15 < (figures.rise_ms or 0) < 30
    assert abs(figures.final_error) < 0.1


def test_every_watcher_has_its_own_grid_and_none_disturbs_the_run() -> None:
    watched, alone = holding(), holding()
    fine = watched.axis("m1").record("yw", interval_ms=0.3)
    coarse = watched.axis("m1").record("yw", "u", interval_ms=1)
    for bench in (watched, alone):
        bench.port("m1").write(b"r100\n")
        bench.run(ms=20_000)
    assert [row[0] for row in coarse.rows] == list(range(5_001_000_000, 25_000_000_001, 1_000_000))
    assert [row[0] for row in fine.rows[:2]] == [5_000_100_000, 5_000_400_000]
    assert len(fine.rows) == 66_667
    assert (fine.lost, coarse.lost) == (0, 0)
    assert watched.axis("m1").snapshot() == alone.axis("m1").snapshot()
    shared = {row[0]: row[1] for row in fine.rows}
    assert all(shared.get(row[0], row[1]) == row[1] for row in coarse.rows)


def test_a_pulse_train_is_followed() -> None:
    bench = holding()
    bench.device("m1").pin("dir", 1)  # its firmware knows edges of dir alone
    start = bench.axis("m1").snapshot().r
    recording = bench.axis("m1").record("r", "yw", "e")
    bench.device("m1").drive(generate(6400, 20_000, 100_000))
    bench.run(ms=800)
    assert recording.column("r")[-1] - start == pytest.approx(360, abs=0.05)  # a float32 sum, as on the board
    assert max(map(abs, recording.column("e"))) < 1
    assert abs(recording.column("yw")[-1] - start - 360) < 0.1


@pytest.mark.parametrize("names", [("foo",), ("at_ns",), ()])
def test_unknown_signals_are_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match="signal"):
        check_signals(names, MECHADUINO)
    with pytest.raises(ValueError, match=r"did you mean.*yw"):
        check_signals(("yv",), MECHADUINO)


def test_too_fine_an_interval_is_refused() -> None:
    with pytest.raises(ValueError, match="write 50us or more"):
        Bench(CONFIG).axis("m1").record("r", interval_ms=0.01)


@pytest.mark.long
def test_drawings(tmp_path: Path) -> None:
    recording = second_order(0.3)
    text = text_plot.draw({"": recording}, 80, colour=False, title="a step")
    assert "\x1b" not in text
    assert "a step" in text
    assert "yw [deg]" in text
    assert max(map(len, text.splitlines())) == 80
    before_and_after = {"before": recording, "after": second_order(0.7)}
    picture.draw(before_and_after, tmp_path / "a.svg", "two", "some figures")
    svg = (tmp_path / "a.svg").read_text()
    ElementTree.fromstring(svg)
    assert "<!-- after: yw [deg] -->" in svg
    picture.draw({"": recording}, tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_that_cannot_be_made(tmp_path: Path) -> None:
    for path in (tmp_path / "a.gif", tmp_path / "none" / "a.png"):
        with pytest.raises(picture.PictureError, match=str(path)):
            picture.draw({"": second_order(0.3)}, path)


def test_csv() -> None:
    recording = Recording(("r", "loop_on"), [(1000, 0.5, 1), (2000, 1.5, 0)])
    assert "".join(recording.csv()) == "at_ns,r,loop_on\n1000,0.5,1\n2000,1.5,0\n"


def test_csv_of_extremes_says_so() -> None:
    recording = Recording(("r",), [(1000, 0.5), (2000, 1.5)], interval_ns=2_500_000, points=50)
    assert "".join(recording.csv()) == (
        "at_ns,r,sampling\n1000,0.5,min/max of each 2.5 ms\n2000,1.5,min/max of each 2.5 ms\n"
    )
    assert Recording(("r",), interval_ns=250_000).sampling == "a sample each 0.25 ms"
    assert Recording(("r",)).sampling == ""


def test_lines_and_axes_of_a_picture_have_words() -> None:
    pytest.importorskip("matplotlib")
    rows = [(at * 1e6, 60.0, at * 0.1, 0.2) for at in range(50)]
    recording = Recording(("velocity_rpm", "yw", "torque_Nm"), rows)
    svg = picture.drawn({"": recording}, ".svg", "rack: m1", "a sample each 1 ms").decode()
    for words in (
        "shaft speed [rpm]", "velocity_rpm [rpm]", "shaft speed", "yw [deg]", "calibrated angle with",
        "turns", "torque [Nm]", "simulated time [s]", "rack: m1", "a sample each 1 ms",
    ):  # fmt: skip
        assert f"<!-- {words} -->" in svg, words


def test_a_set_point_that_is_a_velocity_is_not_drawn_as_an_angle() -> None:
    recording = Recording(("r", "yw", "velocity_rpm"))
    assert recording.panels() == [["r", "yw"], ["velocity_rpm"]]
    recording.units = units_in({"mode": ord("v"), "r": 60.0, "yw": 1.0})
    assert recording.panels() == [["r", "velocity_rpm"], ["yw"]]
    assert recording.label("r") == "r [rpm]"
    assert units_in({"mode": ord("t"), "r": 60.0}) == {"r": ""}
    assert units_in({"mode": ord("v"), "r": 60.0, "e": 1.0}) == {"r": "rpm", "e": "rpm"}
    assert units_in({"mode": ord("x"), "r": 60.0}) == units_in({"position_deg": 0.0, "mode": 118}) == {}


@pytest.mark.parametrize(
    ("signals", "panels"),
    [
        (("r", "yw", "position_deg"), [["r", "yw"], ["position_deg"]]),
        (
            ("speed_rpm", "commanded_deg", "position_deg"),
            [["speed_rpm"], ["commanded_deg"], ["position_deg"]],
        ),
        (("to_be_deg", "measured_deg", "position_deg"), [["to_be_deg", "measured_deg"], ["position_deg"]]),
        (("position_deg", "velocity_rpm"), [["position_deg"], ["velocity_rpm"]]),
    ],
)
def test_angles_of_two_zeros_are_drawn_apart(signals: tuple[str, ...], panels: list[list[str]]) -> None:
    assert Recording(signals).panels() == panels
