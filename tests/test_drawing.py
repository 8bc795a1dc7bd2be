"""The operation ``drawing`` at a bench's desk: problems with their places, figures, path and runs."""

import asyncio
import json
import threading
from pathlib import Path
from typing import Any

import pytest
from desk_support import VIEWER, Asking, Using, desk_in, refusal

from hil.net.answers import misfit
from hil.operations import drawing_operation
from hil.operations.drawing_operation import MACHINE_CHARACTERS, MOST_WAITING
from hil.toolpath.bench_drawing import MOST_PIECES

MACHINE = """machine: plotter
axes:
  x: {axis: m1, deg_per_mm: 9, min_mm: 0, max_mm: 50, velocity_mm_per_min: 3000, acceleration_mm_per_s2: 500}
"""


@pytest.fixture
def using(tmp_path: Path) -> Using:
    return desk_in(tmp_path)


async def drawn(ask: Asking, text: str, machine: str = MACHINE, **given: Any) -> dict[str, Any]:
    """What the operation answers, to a viewer."""
    given |= {"text": text, "machine": machine}
    answer: dict[str, Any] = await ask("drawing", source=VIEWER, **given)
    assert misfit("drawing", answer) == ""
    return answer


def test_a_check_has_figures_and_problems_and_is_shown_to_nobody(using: Using) -> None:
    async def use(ask: Asking) -> None:
        text = "G21 G90\nG0 X10\nG1 X20 F6000\nM2\n"
        checked = await ask("drawing", text=text, machine=MACHINE, check=True)
        assert misfit("drawing", checked) == ""
        assert sorted(checked) == ["figures", "machine", "problems", "remarks"]
        assert checked["figures"]["feed_mm"] == 10
        bad = await drawn(ask, "G21 G90\nG1 X99 F1\nM2\n", check=True)
        assert bad["of"] == "program"
        assert "not_now" in await refusal(ask("drawing"))

    using(use)


def test_a_drawing_is_planned_and_its_problems_have_places(using: Using) -> None:
    async def use(ask: Asking) -> None:
        good = await drawn(ask, "G21 G90\nG0 X10\nG1 X20 F6000\nM2\n")
        assert good["problems"] == []
        assert good["figures"]["feed_mm"] == 10
        assert good["path"]["places"][-2:] == [10, 20]
        assert good["path"]["rapids"] == [[1, 2]]
        assert good["path"]["lines"] == [[1, 2], [2, 3]]
        assert "F6000 is too fast for X" in good["remarks"][0]
        slow = await drawn(ask, "G21 G90\nG1 X20 F600\nM2\n", feed_percent=50.0)
        assert slow["figures"]["duration_s"] > 4
        bad = await drawn(ask, "G21 G90\nG1 X20\nG1 X99 F1\nG7\n", file="part.ngc")
        assert bad["of"] == "program"
        assert [each.split(" ")[0] for each in bad["problems"]] == [
            "part.ngc:2:1:",
            "part.ngc:3:1:",
            "part.ngc:4:1:",
            "part.ngc:4:3:",
        ]
        beyond = await drawn(ask, "G21 G90\nG1 X99 F1\nM2\n", file="part.ngc")
        assert beyond["problems"] == ["part.ngc:2:1: X would go to 99 mm (write 0 to 50)"]

    using(use)


@pytest.mark.parametrize(
    ("text", "machine", "of", "said"),
    [
        ("G0 X1", "", "machine", "machine"),
        ("G0 X1", MACHINE.replace("m1", "m9"), "machine", "the bench has no axis m9"),
        ("G0 X1", MACHINE.replace("max_mm: 50", "max_mm: x"), "machine", "machine:3:"),
        ("G0 X1", MACHINE.replace("axis: m1", "node: 4, steps_per_mm: 8"), "machine", "no axis of the bench"),
        ("X" * (1 << 20), MACHINE, "program", "program:1:"),
        ("\0\0G0\0", MACHINE, "program", "program:1:"),
        ("\ud800 G0", MACHINE, "program", "program:1:"),
        ("\ufeffG0 Ä1", MACHINE, "program", "program:1:"),
    ],
)
def test_bad_input_is_said_with_its_place(using: Using, text: str, machine: str, of: str, said: str) -> None:
    async def use(ask: Asking) -> None:
        bad = await drawn(ask, text, machine)
        assert bad["of"] == of
        assert any(said in each for each in bad["problems"]), bad["problems"]
        assert all(len(each) < 500 for each in bad["problems"])

    using(use)


@pytest.mark.thorough
def test_only_so_much_is_planned(using: Using) -> None:
    async def use(ask: Asking) -> None:
        given = {"text": "G0 X1", "machine": "x" * (MACHINE_CHARACTERS + 1)}
        assert (await refusal(ask("drawing", **given)))[0] == "bad_request"
        many = [asyncio.ensure_future(drawn(ask, "G0 X1\n" * 5_000 + "M2")) for _ in range(MOST_WAITING)]
        await asyncio.sleep(0)
        assert (await refusal(ask("drawing", text="G0 X1", machine=MACHINE)))[0] == "not_now"
        await asyncio.gather(*many)
        assert (await drawn(ask, "G0 X1\nM2"))["problems"] == []

    using(use)


LONG = "G21 G91 F6000\n" + "G1X.001\nG1X-.001\n" * 40_000 + "M2\n"


def planners() -> list[str]:
    """Processes of this one that plan."""
    children = Path(f"/proc/self/task/{threading.get_native_id()}/children").read_text().split()
    return [each for each in children if b"drawing_worker" in Path(f"/proc/{each}/cmdline").read_bytes()]


def test_planning_ends_with_its_asker(using: Using) -> None:
    async def use(ask: Asking) -> None:
        doing = asyncio.ensure_future(drawn(ask, LONG))
        async with asyncio.timeout(120):
            while not planners():
                await asyncio.sleep(0.01)
            doing.cancel()
            await asyncio.gather(doing, return_exceptions=True)
            assert planners() == []
        assert (await drawn(ask, "G0 X1\nM2"))["problems"] == []

    using(use)


def test_pieces_have_a_limit_together_and_the_last_drawing_is_kept_as_it_goes_out(using: Using) -> None:
    machine = MACHINE + MACHINE.splitlines()[2].replace("x:", "y:").replace("m1", "s1") + "\n"

    async def use(ask: Asking) -> None:
        turns = "G17 G2 X20 Y20 I10 J0 P5000\n" * 10
        bad = await drawn(ask, "G21 G90 F6000\nG0 X20 Y20\n" + turns + "M2\n", machine)
        assert bad["problems"] == [
            f"program:3:5: the path up to here needs over {MOST_PIECES} straight pieces"
            " (allow a larger tolerance, or make several programs of it)"
        ]
        assert (await refusal(ask("drawing")))[0] == "not_now"
        good = await ask("drawing", text="G0 X1\nM2", machine=MACHINE, file="a.ngc")
        last, again = ask.desk.ask(VIEWER, "drawing", "", {}), ask.desk.ask(VIEWER, "drawing", "", {})
        assert last is again
        told = {"text": "G0 X1\nM2", "machine_text": MACHINE, "file": "a.ngc", "feed_percent": 100.0}
        assert json.loads(b"".join(last.parts)) == good | told

    using(use)


def test_a_drawing_and_its_run_are_known_by_digests(using: Using) -> None:
    """By names they are not: two drawings of a machine have runs of one name."""

    async def use(ask: Asking) -> None:
        assert (await ask("status"))["drawing"] is None
        await ask.until_ready("m1")
        await ask.verb("m1", "enable")
        one = await drawn(ask, "G21 G90\nG0 X1\nM2\n")
        assert (await ask("status"))["drawing"] is None  # a viewer's is nobody else's
        given = {"machine": MACHINE, "file": "a.ngc"}
        same, other = [await ask("drawing", text=f"G21 G90\nG0 X{x}\nM2\n", **given) for x in (1, 2)]
        assert same["digest"] == one["digest"] != other["digest"]
        assert (await ask("status"))["drawing"] == other["digest"]
        assert (await ask("drawing"))["digest"] == other["digest"]
        progress = await ask("run", text=same["runs"][0]["text"], fresh=True)
        assert progress["digest"] == same["runs"][0]["digest"] != other["runs"][0]["digest"]
        assert [each["digest"] for each in await ask("runs")] == [progress["digest"]]
        await ask("drawing", text="G99", **given)  # what has problems is no drawing
        assert (await ask("status"))["drawing"] == other["digest"]

    using(use)


def test_what_cannot_be_planned_in_time_or_memory_is_refused(
    using: Using, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name, does in {"slow": "while True: pass", "large": "x = bytes(3 << 30)"}.items():
        limits = "resource.setrlimit(resource.RLIMIT_CPU, (1, 2))\n"
        limits += "resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))\n"
        (tmp_path / f"worker_{name}.py").write_text(f"import resource\n{limits}{does}\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    async def use(ask: Asking) -> None:
        for name, why in {"slow": "it takes too long", "large": "its process failed: MemoryError"}.items():
            monkeypatch.setattr(drawing_operation, "WORKER", f"worker_{name}")
            assert await refusal(ask("drawing", text="G0", machine="m")) == (
                "cannot",
                f"program cannot be planned: {why}",
            )

    using(use)
