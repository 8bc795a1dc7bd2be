"""A bus of python-can on a bench's CAN bus, in simulated time."""

import threading
from collections import deque

import can

from bridges.can.bus.bus_events import BusEvent
from bridges.can.cards.channel_node import ChannelNode
from bridges.can.frames.can_frame import CanFrame, check
from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Attach, Detach, Frames, Logged
from hil.testing.bench import Bench
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

_LONGEST_STEP_NS = 1_000_000
_FRAME_BITS = 160
"""More than the longest frame has, with the space behind it."""


class PythonCanBus(can.BusABC):
    """Node of a bus for code that is written with python-can, until ``shutdown``.

    What is sent goes on the bus now. ``recv`` lets simulated time pass until a frame of another node is
    there, or the time-out is over, which is one of simulated time; time stamps are seconds since the bench's
    start.
    One thread may use it beside another that does, as a ``can.Notifier``, if neither runs the bench; then
    nothing is the same twice.
    """

    def __init__(self, bench: Bench, runtime: BenchRuntime, bus: str, node: str) -> None:
        super().__init__(channel=bus)
        self.channel_info = f"{bus} of a bench in simulated time"
        self._bench, self._runtime = bench, runtime
        self._on = runtime.wires_of("can")[bus].bus
        self._group = runtime.parts.group_of(bus)
        self._step_ns = _FRAME_BITS * NS_PER_S // self._on.bit_rate
        self._lock = threading.RLock()
        self._heard: deque[can.Message] = deque()
        self._node = f"{bus}.{node}"
        runtime.apply_input(bus, Attach(node))
        sender = runtime.taps[self._node]
        assert isinstance(sender, ChannelNode)
        self._sender = sender
        self._on.watchers.append(self._hear)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a message.

        Raises:
            can.CanOperationError: it is no frame of classic CAN, or too many wait.
        """
        if msg.is_error_frame or msg.is_fd:
            raise can.CanOperationError("the bus has frames of classic CAN alone")
        remote_dlc = msg.dlc if msg.is_remote_frame else 0
        data = b"" if msg.is_remote_frame else bytes(msg.data)
        frame = CanFrame(
            msg.arbitration_id, data, bool(msg.is_extended_id), bool(msg.is_remote_frame), remote_dlc
        )
        try:
            check(frame)
        except ValueError as error:
            raise can.CanOperationError(str(error)) from None
        with self._lock:
            before = self._sender.refused
            if log := self._runtime.log:
                log.write(Logged(self._group.now_ns, self._node, Frames((str(frame),))))
            self._sender.put((frame,))  # an input whose frame need not be read back from its text
            if self._sender.refused > before:
                raise can.CanOperationError("too many frames wait already")

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Receive a message that passes the filters; None: none came in time."""
        end_ns = None if timeout is None else self._runtime.now_ns + round(timeout * NS_PER_S)
        step_ns = self._step_ns
        while True:
            with self._lock:
                while self._heard:
                    message = self._heard.popleft()
                    if self._matches_filters(message):
                        return message
                now_ns = self._runtime.now_ns
                if end_ns is not None and now_ns >= end_ns:
                    return None
                until_ns = now_ns + step_ns if end_ns is None else min(now_ns + step_ns, end_ns)
                self._bench.run_until(until_ns / NS_PER_MS)
            step_ns = min(2 * step_ns, _LONGEST_STEP_NS)

    def shutdown(self) -> None:
        """Leave the bus."""
        super().shutdown()
        if self._hear in self._on.watchers:
            self._on.watchers.remove(self._hear)
            self._runtime.apply_input(self._node, Detach())

    def _hear(self, event: BusEvent) -> None:
        if event.frame and event.node != self._node:
            self._heard.append(_message(event.frame, event.at_ns))


def _message(frame: CanFrame, at_ns: SimTimeNs) -> can.Message:
    return can.Message(
        at_ns / NS_PER_S,
        frame.id,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        dlc=frame.dlc,
        data=None if frame.is_remote else frame.data,
    )
