"""Replies to a verb: those beside the acknowledgement, and what comes when the device has gone."""

import asyncio
import json
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any, cast

import pytest

from bridges.zenoh.command_handler import CommandHandler, Work
from bridges.zenoh.inbox import Request
from bridges.zenoh.publications import Publications
from bridges.zenoh.readings import Readings
from bridges.zenoh.sender import Sender
from hil.vocab.desk_protocol import AxisField, Description, Desk, DeviceInfo, Done
from hil.vocab.verbs import VerbRefused

SET_POINT = AxisField("r", "f32", "deg", "set-point", 8, False, True)


class OneClock:
    def times_ns(self) -> tuple[int, int]:
        return 5, 7

    def wall_ns(self, sim_ns: int) -> int:
        return sim_ns


class OneDesk:
    """A twin and a real board; ``gone``: a reload takes the twin away while its motion's end is awaited."""

    def __init__(self, *, gone: bool = False) -> None:
        self.devices = {
            "m1": DeviceInfo("m1", "mechaduino", False, {}, {"r": SET_POINT}),
            "real": DeviceInfo("real", "mechaduino", True, {}, {}),
        }
        self.gone = gone

    def describe(self) -> Description:
        return Description("b", OneClock(), self.devices, (), (), {})

    def ask(self, source: Any, operation: str, target: str, given: Mapping[str, object]) -> Any:
        if operation == "do":
            return Done(3, {})
        if not self.devices[target].is_seen:
            raise VerbRefused("cannot", "its terminal is all that is seen")
        return self.wait() if operation == "wait" else {}

    async def wait(self) -> Mapping[str, object]:
        if self.gone:
            del self.devices["m1"]
        return {"interrupted": self.gone}


class Replies:
    """Stand-in for the sender and the publications, which keeps what it is given."""

    def __init__(self) -> None:
        self.said: list[Mapping[str, Any]] = []
        self.ends = 0
        self.rejected = 0

    def reply(self, query: Any, key: str, content: bytes, encoding: Any) -> None:
        self.said.append(json.loads(content))

    def refuse(self, query: Any, content: bytes, encoding: Any) -> None:
        self.said.append(json.loads(content))

    def end(self, query: Any) -> None:
        self.ends += 1


def replies_to(desk: OneDesk, device: str, *wanted: str) -> Replies:
    replies, work = Replies(), Work()

    def rejected(text: bytes) -> None:
        replies.rejected += 1

    commands = CommandHandler(
        cast(Desk, desk),
        None,
        cast(Publications, SimpleNamespace(rejected=rejected)),
        cast(Readings, None),
        cast(Sender, replies),
        work,
    )

    async def main() -> None:
        query: Any = SimpleNamespace(parameters=dict.fromkeys(wanted, "true"))
        commands.handle(Request(f"hil/b/axis/{device}/cmd/type", b'{"text": "p"}', None, query))
        async with asyncio.timeout(30):
            while work.waiting:
                await asyncio.sleep(0)

    asyncio.run(main())
    return replies


@pytest.mark.parametrize("wanted", [(), ("applied",), ("done",), ("applied", "done")])
def test_what_was_typed_at_a_real_board_is_acknowledged_alone(wanted: tuple[str, ...]) -> None:
    replies = replies_to(OneDesk(), "real", *wanted)
    assert [each["effective_at_ns"] for each in replies.said] == [3]
    assert (replies.ends, replies.rejected) == (1, 0)


def test_a_motion_whose_device_a_reload_takes_away_ends_for_its_asker() -> None:
    replies = replies_to(OneDesk(gone=True), "m1", "done")
    assert replies.said[-1]["interrupted"] is True
    assert replies.said[-1]["state"] == {}
    assert replies.ends == 1
