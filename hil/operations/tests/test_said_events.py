"""Lines of the daemon's log as events: from threads, before the events are there, in a flood."""

import asyncio
import logging
import threading

from hil.operations.event_log import EventLog
from hil.operations.said_events import KIND, MOST_PER_S, SaidEvents

log = logging.getLogger("hil.test_said_events")


def said(events: EventLog) -> list[tuple[str, str]]:
    return [(each["of"], each["text"]) for each in events.told(0)["events"] if each["kind"] == KIND]


def with_handler(act: "object") -> EventLog:
    """Run a function with a handler of the log and the events, in a loop."""
    events = EventLog(lambda: 0)

    async def run() -> None:
        handler = SaidEvents(asyncio.get_running_loop(), lambda name: name == "m1")
        log.addHandler(handler)
        log.setLevel(logging.INFO)
        try:
            act(handler, events)  # type: ignore[operator]
            await asyncio.sleep(0)
        finally:
            handler.end()
            log.removeHandler(handler)

    asyncio.run(run())
    return events


def test_lines_have_their_level_and_the_device_that_they_are_of() -> None:
    def act(handler: SaidEvents, events: EventLog) -> None:
        handler.begin(events)
        log.warning("m1: it is hot")
        log.error("other: %s", "words")
        log.info("a token")

    assert said(with_handler(act)) == [("m1", "WARNING it is hot"), ("", "ERROR other: words")]


def test_lines_before_the_events_wait() -> None:
    def act(handler: SaidEvents, events: EventLog) -> None:
        log.error("early")
        asyncio.get_running_loop().call_soon(handler.begin, events)

    assert said(with_handler(act)) == [("", "ERROR early")]


def test_a_line_that_an_event_says_already_is_none() -> None:
    def act(handler: SaidEvents, events: EventLog) -> None:
        handler.begin(events)
        log.warning("m1: it stalled")
        events.put("motors", "m1", "bench", "it stalled")

    assert said(with_handler(act)) == []


def test_a_flood_is_counted() -> None:
    def act(handler: SaidEvents, events: EventLog) -> None:
        handler.begin(events)
        for number in range(MOST_PER_S * 4):
            log.warning("line %d of many", number)

    assert len(said(with_handler(act))) <= 2 * MOST_PER_S + 2


def test_threads_and_exceptions() -> None:
    def fail() -> None:
        try:
            raise OSError("disk\nfull")
        except OSError:
            log.exception("it failed")

    def act(handler: SaidEvents, events: EventLog) -> None:
        handler.begin(events)
        thread = threading.Thread(target=fail)
        thread.start()
        thread.join()

    assert said(with_handler(act)) == [("", "ERROR it failed: OSError('disk\\nfull')")]


def test_after_the_end_nothing_is_noted() -> None:
    def act(handler: SaidEvents, events: EventLog) -> None:
        handler.begin(events)
        log.warning("before")
        handler.end()
        log.warning("after")

    assert said(with_handler(act)) == []
