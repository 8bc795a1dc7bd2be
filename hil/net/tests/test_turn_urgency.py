"""Order of turns: a stop needs none, commands come before readings."""

import asyncio

from hil.net.fair_share import IN_A_PASS, FairShare
from hil.vocab.operation import STOP_VERB, Operation, Target, Urgency, urgency_of
from hil.vocab.verbs import Role, VerbRefused


def operation(name: str, role: Role) -> Operation:
    return Operation(name, Target.BENCH, "", role=role)


def test_classes_of_operations() -> None:
    do = operation("do", Role.VIEWER)
    assert urgency_of(do, {"name": STOP_VERB}) is Urgency.STOP
    assert urgency_of(do, {"name": "move_abs"}) is Urgency.COMMAND
    assert urgency_of(operation("status", Role.VIEWER), {"name": STOP_VERB}) is Urgency.READING
    assert urgency_of(operation("stop", Role.ADMIN), {}) is Urgency.COMMAND


def test_a_stop_waits_for_nobody_and_a_command_for_no_reading() -> None:
    order: list[str] = []

    async def asks(turns: FairShare, name: str, urgency: Urgency) -> None:
        await turns.wait(urgency)
        turns.note(None, 0.002)  # more than the burst: all others wait
        order.append(name)

    async def main() -> None:
        turns = FairShare()
        readings = [asks(turns, f"reading{n}", Urgency.READING) for n in range(3 * IN_A_PASS)]
        tasks = [asyncio.create_task(each) for each in readings]
        await asyncio.sleep(0)
        tasks.append(asyncio.create_task(asks(turns, "command", Urgency.COMMAND)))
        await asyncio.sleep(0)
        tasks.append(asyncio.create_task(asks(turns, "stop", Urgency.STOP)))
        async with asyncio.timeout(120):
            await asyncio.gather(*tasks)
        turns.close()

    asyncio.run(main())
    readings = [f"reading{n}" for n in range(3 * IN_A_PASS)]
    assert [each for each in order if each.startswith("reading")] == readings
    assert order[IN_A_PASS : IN_A_PASS + 2] == ["stop", "command"]


def test_a_verb_that_a_stop_has_overtaken_is_refused_and_no_other() -> None:
    told: dict[str, str] = {}

    async def moves(turns: FairShare, name: str) -> None:
        try:
            await turns.wait(Urgency.COMMAND, name)
            told[name] = "carried out"
        except VerbRefused as refusal:
            told[name] = f"{refusal.code}: {refusal}"

    async def main() -> None:
        turns = FairShare()
        while turns.spend():
            pass
        turns.note(None, 0.002)  # more than the burst: whoever comes now waits
        names = ("m1", "m1.elbow", "m10", "m2", "")
        tasks = [asyncio.create_task(moves(turns, name)) for name in names]
        await asyncio.sleep(0)
        assert not told
        turns.stopped("m1")
        tasks.append(asyncio.create_task(moves(turns, "m1.wrist")))  # asked for after the stop
        async with asyncio.timeout(120):
            await asyncio.gather(*tasks)
        turns.close()

    refused = "not_now: a stop of {} came while this waited; ask for it again"
    asyncio.run(main())
    assert told == {
        **{name: refused.format(name) for name in ("m1", "m1.elbow")},
        **dict.fromkeys(("m10", "m2", "", "m1.wrist"), "carried out"),
    }
