"""Steps that dialogues with boards share."""

from collections.abc import Generator
from typing import Any

from hil.vocab.dialogue import Heard, Listen, Step


def wait_until(at_ns: int) -> Generator[Step, Any, int]:
    """Wait until this time; what comes meanwhile is not kept. Answers the time."""
    heard: Heard = yield Listen(0)
    while heard.at_ns < at_ns:
        heard = yield Listen(at_ns - heard.at_ns)
    return heard.at_ns
