"""The stop of all over zenoh: it comes before all that waits, and what it passes moves nothing."""

import pytest

from bridges.zenoh.command_handler import Command, command_at
from bridges.zenoh.inbox import Request
from bridges.zenoh.keys import KEYS
from hil.vocab.operation import Urgency


@pytest.mark.parametrize("payload", [None, b"{}", b'{"how": "prejudice"}'])
def test_it_is_a_command_of_the_bench(payload: bytes | None) -> None:
    reader = command_at("halt", bool(payload))
    assert reader is not None
    command = reader(payload)
    assert (command.operation, command.target, command.is_stop) == ("halt", "", True)


def test_it_is_as_urgent_as_the_stop_of_an_axis() -> None:
    halt = Request("hil/b/halt", b"{}", None, None, "halt")
    stop = Request("hil/b/axis/m1/cmd/stop", b"{}", None, None, "axis/<device>/cmd/<verb>")
    move = Request("hil/b/axis/m1/cmd/move_abs", b"{}", None, None, "axis/<device>/cmd/<verb>")
    assert [each.urgency for each in (halt, stop, move)] == [Urgency.STOP, Urgency.STOP, Urgency.COMMAND]
    assert "halt" in {key.pattern for key in KEYS}


def test_a_verb_of_that_name_is_none() -> None:
    assert not Command("do", "m1", {"name": "halt", "parameters": {}}).is_stop
