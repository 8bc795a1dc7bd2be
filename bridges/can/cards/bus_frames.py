"""Frames on a bench's bus, in captures and for the page."""

from collections.abc import Callable, Mapping
from typing import Any

from bridges.can.bus.bus_events import BusEvent
from hil.vocab.wire import FrameKind


def _packed(event: BusEvent) -> bytes:
    from bridges.can.frames.socketcan import pack_error, pack_frame

    return pack_frame(event.frame) if event.frame else pack_error(event.error or event.state)


def _words() -> Callable[[BusEvent], Mapping[str, Any]]:
    from bridges.can.canopen.words.canopen_words import CanOpenWords

    words = CanOpenWords({}, {})

    def described(event: BusEvent) -> Mapping[str, Any]:
        frame = event.frame
        meaning = words.say(frame) if frame else ""
        return {
            "at_s": event.start_ns / 1e9,
            "from": event.node,
            "frame": str(frame) if frame else None,
            "id": frame.id if frame else None,
            "hex": frame.data.hex() if frame else "",
            "text": meaning or event.error or event.state,
            "error": event.error or None,
            "state": event.state or None,
            "duration_s": (event.at_ns - event.start_ns) / 1e9,
        }

    return described


FRAMES = FrameKind(_packed, _words)
