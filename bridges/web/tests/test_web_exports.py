"""Captures for pages: made while they go out, one for a page at a time, and only so many."""

import base64
import json
from collections.abc import Callable

import pytest

from bridges.web.web_client import MOST_EXPORTS, Exports
from bridges.web.wire_streams import RECORDED_EVENTS, Captured
from hil.vocab.verbs import VerbRefused


def captured(events: int, record: Callable[[int, int], bytes] = lambda event, _: b"ab") -> Captured:
    return Captured(b"head", record, range(events), 0)


@pytest.mark.parametrize("events", [0, 1, RECORDED_EVENTS, 3 * RECORDED_EVENTS + 7])
def test_a_capture_is_one_answer(events: int) -> None:
    message = Exports().begin("page", 7, captured(events))
    answer = json.loads(b"".join(message.parts))
    assert answer["id"] == 7
    assert answer["answer"]["events"] == events
    assert base64.b64decode(answer["answer"]["pcapng_base64"], validate=True) == b"head" + b"ab" * events


def test_it_is_made_while_it_goes_out() -> None:
    made: list[int] = []

    def record(event: int, epoch_ns: int) -> bytes:
        made.append(event)
        return b"."

    parts = iter(Exports().begin("page", 1, captured(1000, record)).parts)
    assert made == []
    for _ in range(3):
        next(parts)
    assert len(made) == RECORDED_EVENTS


def test_only_so_many_are_under_way() -> None:
    exports = Exports()
    under_way = [exports.begin(page, 1, captured(9)) for page in range(MOST_EXPORTS)]
    with pytest.raises(VerbRefused, match="to this page"):
        exports.begin(0, 2, captured(9))
    with pytest.raises(VerbRefused, match=f"{MOST_EXPORTS} captures"):
        exports.begin("another", 2, captured(9))
    under_way[0].sent()
    exports.begin("another", 2, captured(9))
