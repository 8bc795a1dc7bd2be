"""Media, which the programs at a channel share, and conversion of python-can's messages to frames."""

import asyncio
from collections.abc import Callable, Sequence
from typing import Protocol

from can import Message

from bridges.can.frames.can_frame import CanFrame, check

AT_A_TIME = 64
"""Frames that are taken in one turn of the event loop."""

Take = Callable[[Sequence[CanFrame]], None]
"""Called in the event loop with frames of programs, in their order."""


class Medium(Protocol):
    """Way to programs outside. ``rejected``: number of messages that were no frames of classic CAN;
    ``strangers``: of those that came from other computers, which may not."""

    rejected: int
    strangers: int
    failure: str
    """Reason why nothing comes any more; empty: there is none."""

    def open(self, loop: asyncio.AbstractEventLoop, take: Take) -> None:
        """Open it. Raises BridgeError."""

    def send(self, frame: CanFrame, at_s: float) -> bool:
        """Send a frame, which was on the bus at this time, in seconds since 1970; never waits. False: there
        is no room for it."""

    def hold(self, is_held: bool) -> None:
        """Take nothing for now, or go on."""

    async def close(self) -> None:
        """Close it, open or not."""


def message_of(frame: CanFrame, at_s: float) -> Message:
    """Make python-can's message of a frame."""
    return Message(
        at_s,
        frame.id,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        dlc=frame.dlc,
        data=None if frame.is_remote else frame.data,
    )


def frame_of(message: Message) -> CanFrame | None:
    """Make a frame of python-can's message; None if it is none of classic CAN."""
    if message.is_error_frame or message.is_fd:
        return None
    is_remote = bool(message.is_remote_frame)
    data = b"" if is_remote else bytes(message.data)
    frame = CanFrame(
        message.arbitration_id, data, bool(message.is_extended_id), is_remote, message.dlc if is_remote else 0
    )
    try:
        check(frame)
    except (TypeError, ValueError):
        return None
    return frame
