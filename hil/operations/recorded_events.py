"""Events of a bench on their way into its recording."""

from collections.abc import Mapping
from typing import Any

from hil.live.run_recording import RunRecording
from hil.sim.noted_events import NotedEvent, noted_event

OVER_NS = 1_000_000_000
"""Time after which no other joins an event."""


class RecordedEvents:
    """Receiver of events, which writes each into the recording at once. One that others join is written again
    when their number has doubled, and when no more join it."""

    def __init__(self, recording: RunRecording) -> None:
        self._recording = recording
        self._joined: dict[int, NotedEvent] = {}
        self._last = 0

    def put(self, event: Mapping[str, Any]) -> None:
        """Take an event; a listener of the bench's events."""
        noted = noted_event(event)
        for number, each in list(self._joined.items()):
            if noted.to_ns - each.to_ns > OVER_NS:
                self._write(self._joined.pop(number))
        if noted.number > self._last or noted.count & (noted.count - 1) == 0:
            self._last = max(self._last, noted.number)
            self._joined.pop(noted.number, None)
            self._write(noted)
        else:
            self._joined[noted.number] = noted

    def end(self) -> None:
        """Write what others joined."""
        for event in self._joined.values():
            self._write(event)
        self._joined.clear()

    def _write(self, event: NotedEvent) -> None:
        if writer := self._recording.writer:
            writer.add(event)
