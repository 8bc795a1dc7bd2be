"""Examples of ``README.md`` and ``docs/tour.md`` in virtual time; ``test_e2e_tour.py`` starts a daemon."""

import ast
import re
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
import yaml
from markdown_blocks import ROOT, block, blocks, fits

from hil.telemetry import step_response
from hil.testing import Bench

README, TOUR = "README.md", "docs/tour.md"
HERE = {
    (README, "Test your program"): 1,
    (TOUR, "Type at the Mechaduino"): 6,
    (TOUR, "Type at the SAC"): 2,
    (TOUR, "Two SACs on one wire"): 2,
    (TOUR, "See it move"): 1,
}
"""Blocks that this file checks, counted by page and heading."""
IN_A_DAEMON = {
    (README, "hil"): 1,
    (README, "Start"): 1,
    (TOUR, "Tour"): 1,
    (TOUR, "Use it from a program"): 2,
    (TOUR, "Look at the bench"): 1,
    (TOUR, "Make it fail"): 1,
    (TOUR, "Record a run and run it again"): 1,
}
"""The same of ``test_e2e_tour.py``."""
MOST_LINES = 115
"""Maximum length of the README: somebody reads all of it."""
WORDS = ("client", "bench", "port", "device", "axis", "segment", "tap", "door")
PROMPT = "SAC>"
BOOT_MS = {"mechaduino": 4000, "sac": 1150}

MakeBench = Callable[..., Bench]


CALIBRATED = {"flash": {"table": "identity"}}
"""Option of the Mechaduino of ``examples/demo.yaml``."""


def at_boot(bench: MakeBench, profile: str, **options: Any) -> Bench:
    made = bench({"bench": "t", "devices": {"d1": {"profile": profile, **options}}})
    made.run(ms=BOOT_MS[profile])
    made.port("d1").read()
    return made


def typed(bench: Bench, text: bytes, ms: float, name: str = "d1") -> str:
    bench.port(name).write(text)
    bench.run(ms=ms)
    return bench.port(name).read().decode()


# ---- the pages ----


def test_every_block_is_checked() -> None:
    found = Counter((page, each.heading) for page in (README, TOUR) for each in blocks(page))
    assert found == HERE | IN_A_DAEMON


def test_the_readme_is_short() -> None:
    assert len((ROOT / README).read_text().splitlines()) <= MOST_LINES


def test_the_picture_has_the_words_that_are_explained_below_it() -> None:
    picture = (ROOT / "docs" / "images" / "bench.svg").read_text()
    drawn = set(re.findall(r'class="[\w ]*\bword"[^>]*>(\w+)<', picture))
    assert {"client" if word == "clients" else word for word in drawn} == set(WORDS)
    explained = set(re.findall(r"\*\*(\w+)\*\*", (ROOT / README).read_text()))
    assert explained == set(WORDS) - {"bench"}


def test_a_page_that_shows_something_else_does_not_fit() -> None:
    assert fits("a\n...\nd\n", "a\r\nb\r\nc \r\nd\r\n")
    assert fits("a\n...\n", "a\n")
    assert fits("took 3 ms", "took 45 ms", r"\d+")
    assert not fits("a\n...\nd\n", "a\nb\n")
    assert not fits("took 3 ms", "took x ms", r"\d+")
    assert not fits("a.c", "abc")


# ---- typed at the Mechaduino ----


def test_the_menu(bench: MakeBench) -> None:
    assert fits(block(TOUR, "Type at the Mechaduino", 0), typed(at_boot(bench, "mechaduino"), b"m", 100))


def test_an_angle_a_set_point_and_the_step(bench: MakeBench) -> None:
    made = at_boot(bench, "mechaduino", **CALIBRATED)
    _, first, moved, angle, step, _ = (block(TOUR, "Type at the Mechaduino", n) for n in range(6))
    assert fits(first, typed(made, b"p", 200))
    said = (
        typed(made, b"x", 100) + typed(made, b"y", 100) + typed(made, b"r", 100) + typed(made, b"90\n", 1000)
    )
    assert fits(moved, said)
    assert fits(angle, typed(made, b"p", 200))
    assert fits(f"...\n{step}", typed(made, b"yj", 2500))


def test_a_calibration(bench: MakeBench) -> None:
    made = at_boot(bench, "mechaduino")
    assert fits(block(TOUR, "Type at the Mechaduino", 5), typed(made, b"c", 27_000))


def figures(line: str) -> list[float]:
    return [float(number) for number in re.findall(r"[-+]?\d+\.\d+", line)]


def test_the_step_response(bench: MakeBench) -> None:
    """The response is as ``hil step`` makes it, which ``test_e2e_draw.py`` runs."""
    made = at_boot(bench, "mechaduino")
    typed(made, b"c", 27_000)
    typed(made, b"xy", 300)
    recording = made.axis("d1").record("r", "yw", "u", interval_ms=0.25)
    made.run(ms=50)
    typed(made, b"r90\n", 500)
    shown, real = block(TOUR, "See it move").strip(), step_response(recording).line("deg")
    assert fits(shown, real, r"[-+]?\d+\.\d+")
    assert figures(real) == pytest.approx(figures(shown), rel=0.05, abs=0.1)


# ---- typed at the SAC ----


def typed_at(session: str) -> list[bytes]:
    """Lines that are typed at the prompt."""
    lines = session.splitlines()
    return [line.removeprefix(PROMPT).encode() + b"\r" for line in lines if line.startswith(PROMPT)]


@pytest.mark.parametrize(
    ("page", "heading", "index"),
    [(TOUR, "Type at the SAC", 0), (TOUR, "Type at the SAC", 1)],
)
def test_a_session_with_the_sac(bench: MakeBench, page: str, heading: str, index: int) -> None:
    made = at_boot(bench, "sac")
    if index:  # a loop over the queue of the session before
        for line in typed_at(block(page, heading, 0)):
            typed(made, line, 100)
    session = block(page, heading, index)
    said = "".join(
        typed(made, line, 2000 if line.startswith(b"m3000") else 100) for line in typed_at(session)
    )
    assert fits(session, PROMPT + said.removesuffix(PROMPT))


# ---- on one wire ----


def test_one_board_commands_the_other(bench: MakeBench) -> None:
    text = block(TOUR, "Two SACs on one wire")
    assert yaml.safe_load(text)["segments"]["bus0"]["taps"] == {"master": {"port": "pty"}}
    made = bench(text)
    made.run(ms=BOOT_MS["sac"])
    typed(made, b"$CM86\r", 100, "s2")
    typed(made, b"$R\r", 100, "s2")
    typed(made, b"86m3000v150\r", 100, "s1")
    assert made.axis("s2").snapshot().motion_state
    assert not made.axis("s1").snapshot().motion_state
    typed(made, b"86 hello\r", 100, "s1")
    assert fits(block(TOUR, "Two SACs on one wire", 1), made.port("s2").read().decode().removesuffix(PROMPT))
    made.fault("packet_no_ack", "s2.network")


# ---- a test ----


def test_the_test_passes(bench: MakeBench) -> None:
    code = block(README, "Test your program")
    (function,) = ast.parse(code).body
    assert isinstance(function, ast.FunctionDef)
    names: dict[str, Callable[[MakeBench], None]] = {}
    exec(compile(code, README, "exec"), names)
    names[function.name](bench)
