"""The stop of all that moves, and the events of a bench, at the desk of a daemon."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from desk_support import ADMIN, OPERATOR, VIEWER, Asking, Using, desk_in, refusal
from e2e_support import READY_NS, Place, config

from hil.vocab.desk_protocol import Watched
from hil.vocab.verbs import VerbRefused

RUN = "run: slow\naxes: {s1: {velocity_rpm: 60}}\nsteps: [{move: {s1: 36000}}]\n"


@pytest.fixture
def using(tmp_path: Path) -> Using:
    """Runs what is awaited with the desk of a daemon that has started."""
    return desk_in(tmp_path)


async def moves(ask: Asking, axis: str) -> bool:
    return ask.serving.live.devices[axis].look("").motion.is_moving


async def until(holds: Any) -> None:
    async with asyncio.timeout(40):
        while not await holds():
            await asyncio.sleep(0.01)


async def texts(ask: Asking, kind: str) -> list[tuple[str, str, str]]:
    events = (await ask("events", source=VIEWER))["events"]
    return [(each["of"], each["who"], each["text"]) for each in events if each["kind"] == kind]


@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_a_halt_stops_what_moves_and_leaves_what_stands(using: Using, how: str) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        await ask.until_ready("s10")
        await ask.verb("m1", "enable")
        answer = await _halted(ask, "velocity", {"velocity_rpm": 60}, how)
        assert answer["stopped"] == ["m1"]
        assert answer["runs"] == []
        assert list(answer["refused"]) in (
            ["real"],
            [],
        )  # nobody knows whether a board that is away moves
        await until(lambda: _stands(ask, "m1"))

    using(use)


@pytest.mark.parametrize(
    ("verb", "given"), [("velocity", {"velocity_rpm": 60}), ("torque", {"effort_count": 40})]
)
def test_a_halt_stops_what_was_told_to_turn_and_stands_yet(
    using: Using, verb: str, given: dict[str, float]
) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        await ask.verb("m1", "enable")
        await ask("inject", target="m1", fault="shaft_jam", parameters={})
        assert (await _halted(ask, verb, given))["stopped"] == ["m1"]
        await until(lambda: _stands(ask, "m1"))

    using(use)


async def _halted(ask: Asking, verb: str, given: dict[str, float], how: str = "grace") -> dict[str, Any]:
    """Let m1 turn, and halt; again where the time-out of its set-point, 2.5 ms of the wall, came first."""
    answer: dict[str, Any] = {}
    for _ in range(50):
        await ask.verb("m1", verb, **given)
        answer = await ask("halt", source=OPERATOR, how=how)
        if answer["stopped"]:
            break
    return answer


async def _stands(ask: Asking, axis: str) -> bool:
    return not await moves(ask, axis)


def test_a_halt_ends_runs_that_move_and_those_that_wait(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("s1")
        for name in ("slow", "next"):
            await ask("run", text=RUN.replace("slow", name), file="r.yaml")
        await until(lambda: moves(ask, "s1"))
        answer = await ask("halt")
        assert answer["runs"] == ["slow", "next"]
        assert "s1" in answer["stopped"]
        await until(lambda: _stands(ask, "s1"))
        states = {row["run"]: row["state"] for row in await ask("runs")}
        assert states == {"slow": "cancelled", "next": "cancelled"}
        said = [text for _, _, text in await texts(ask, "runs")]
        assert {"slow submitted", "slow running"} <= set(said)
        assert any(text.startswith("next cancelled") for text in said)

    using(use)


def test_a_viewer_may_not_halt(using: Using) -> None:
    async def use(ask: Asking) -> None:
        assert (await refusal(ask("halt", source=VIEWER)))[0] == "forbidden"
        assert ("", "a guest", "halt: halt needs the role operator") in await texts(ask, "refusals")

    using(use)


def test_events_tell_who_asked_for_what_and_what_was_refused(using: Using) -> None:
    async def use(ask: Asking) -> None:
        heard: list[Any] = []
        watch = ask.desk.watch(VIEWER, Watched.EVENTS, "", heard.append)
        await ask.until_ready("m1")
        await ask.verb("m1", "enable", OPERATOR)
        await refusal(ask.verb("m1", "jump", OPERATOR))
        await ask("type", "s1", text="P")
        number = (await ask("inject", "s1", fault="shaft_jam", parameters={"for_s": 1000}))["number"]
        await ask("clear", number=number)
        ask.desk.note_refusal(ADMIN, "do", "m1", {"name": "enable"}, VerbRefused("not_now", "too late"))
        assert await texts(ask, "verbs") == [("m1", "a hand", "enable")]
        assert await texts(ask, "typed") == [("s1", "the tests", "type text P")]
        assert await texts(ask, "faults") == [
            ("s1", "the tests", "shaft_jam for_s 1000"),
            ("", "the tests", f"cleared {number}"),
        ]
        refusals = await texts(ask, "refusals")
        assert refusals[0][2].startswith("jump: m1, a mechaduino, has no 'jump'")
        assert refusals[1] == ("m1", "the tests", "enable: too late")
        assert [each["kind"] for each in heard].count("faults") == 2
        watch.close()

    using(use)


def test_a_fault_that_ends_by_itself_and_a_trouble_are_told(using: Using) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        await ask("inject", "m1", fault="node_brown_out", parameters={})
        await ask("inject", "s1", fault="shaft_jam", parameters={"for_s": 25})

        async def are_told() -> bool:
            faults, trouble = await texts(ask, "faults"), await texts(ask, "trouble")
            has_ended = any("ended: shaft_jam on s1" in text for *_, text in faults)
            return has_ended and any(of == "m1" for of, *_ in trouble)

        await until(are_told)

    using(use)


def test_a_halt_of_axes_leaves_the_others(using: Using) -> None:
    async def use(ask: Asking) -> None:
        for name in ("s1", "s10"):
            await ask.until_ready(name)
        await ask("run", source=OPERATOR, text=RUN, file="r.yaml")
        await ask(
            "run", source=OPERATOR, text=RUN.replace("slow", "more").replace("s1:", "s10:"), file="r.yaml"
        )
        await until(lambda: moves(ask, "s1"))
        await until(lambda: moves(ask, "s10"))
        code, text = await refusal(ask("halt", source=OPERATOR, axes=["s1", "q1"]))
        assert (code, text.partition(";")[0]) == ("no_device", "there is no axis 'q1'")
        answer = await ask("halt", source=OPERATOR, axes=["s10"])
        assert answer == {"stopped": ["s10"], "runs": ["more"], "refused": {}}
        await until(lambda: _stands(ask, "s10"))
        assert await moves(ask, "s1")
        assert (await ask("halt", source=OPERATOR, axes=["s1"]))["runs"] == ["slow"]

    using(use)


def test_hil_stop_says_what_it_stopped(place: Place) -> None:
    server = place.serve(config(devices={"m1": {"flash": {"table": "identity"}}}))
    server.ready("m1", boot_ns=READY_NS)
    where = ("--runtime-dir", str(place.runtime))
    runs_on = f"hil: the bench runs on; `hil --runtime-dir {place.runtime} shutdown` ends it\n"
    assert place.cli("stop", *where) == f"{runs_on}nothing moves\n"
    server.ask("do", device="m1", name="enable", parameters={})
    server.ask("do", device="m1", name="velocity", parameters={"velocity_rpm": 100})
    assert place.cli("stop", "--at-once", *where) == "m1: stops\n"
