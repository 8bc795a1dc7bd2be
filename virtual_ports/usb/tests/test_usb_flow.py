"""Bytes between a host's program and the board, whatever is unlinked, throttled or under way meanwhile."""

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from linux_host import BULK_OUT, LinuxHost

from hil.vocab.ports import ADAPTER
from virtual_ports.usb.cdc_acm import CdcAcm
from virtual_ports.usb.descriptors import Descriptors
from virtual_ports.usb.urb import Submit

UNLINKED = -104
SIZES = st.sampled_from([0, 1, 2, 63, 64, 65, 128, 1000])
BREAK = b"\0"


class Flow(RuleBasedStateMachine):
    """A program has the tty open. Each write has a byte of its own, so that it is known again."""

    def __init__(self) -> None:
        super().__init__()
        self.host, self.device = LinuxHost(), CdcAcm(Descriptors(ADAPTER, "s"))
        self.host.enumerate()
        self.host.open()
        self.to_device = bytearray()
        self.to_host = bytearray()
        self.sent = bytearray()
        """What the board has sent."""
        self.taken = bytearray()
        """What the board has taken."""
        self.writes: list[tuple[bytes, list[int]]] = []
        """Writes of the program, each with its status once it is answered."""
        self.pending: list[int] = []
        self.settle()

    def settle(self) -> None:
        """Let all pass that is under way."""
        size = -1
        while size:
            size = self.wire_to_device(1 << 30) + self.wire_to_host(1 << 30)

    @rule(size=SIZES)
    def board_sends(self, size: int) -> None:
        if self.device.is_heard:
            data = bytes(at % 251 for at in range(len(self.sent), len(self.sent) + size))
            self.sent += data
            self.device.to_host.send(data)

    @rule(size=SIZES)
    def board_takes(self, size: int) -> None:
        self.taken += self.device.from_host.drain(size)

    @rule(size=SIZES)
    def program_writes(self, size: int) -> None:
        data = bytes((len(self.writes) % 255 + 1,)) * size
        statuses: list[int] = []
        self.writes.append((data, statuses))
        self.pending.append(
            self.host.submit(BULK_OUT, False, data, lambda status, _: statuses.append(status))
        )

    @rule()
    def program_breaks(self) -> None:
        self.host.send_break(0xFFFF)

    @precondition(lambda self: self.pending)
    @rule(which=st.integers(0, 1 << 30))
    def host_unlinks_a_write(self, which: int) -> None:
        self.host.unlink(self.pending.pop(which % len(self.pending)))

    @rule(which=st.integers(0, 1 << 30))
    def host_unlinks_a_read(self, which: int) -> None:
        reads = [seqnum for seqnum, urb in self.host.urbs.items() if urb.done == self.host._has_read]
        if len(reads) > 1:
            self.host.unlink(reads[which % len(reads)])

    @rule()
    def program_stops_reading(self) -> None:
        self.host.is_throttled = True

    @rule()
    def program_reads(self) -> None:
        self.host.unthrottle()

    @rule(on=st.booleans())
    def program_sets_a_line(self, on: bool) -> None:
        self.host.set_lines(dtr=on, rts=True)

    @rule(size=st.integers(1, 3000))
    def some_comes_to_the_device(self, size: int) -> None:
        self.wire_to_device(size)

    @rule(size=st.integers(1, 3000))
    def some_comes_to_the_host(self, size: int) -> None:
        self.wire_to_host(size)

    def wire_to_device(self, size: int) -> int:
        self.to_device += self.host.take()
        data = bytes(self.to_device[:size])
        del self.to_device[:size]
        self.device.receive(data)
        return len(data)

    def wire_to_host(self, size: int) -> int:
        self.to_host += self.device.take_answers()
        data = bytes(self.to_host[:size])
        del self.to_host[:size]
        self.host.receive(data)
        return len(data)

    @invariant()
    def nothing_is_out_of_order(self) -> None:
        assert self.sent.startswith(self.host.received)

    def teardown(self) -> None:
        self.host.unthrottle()
        for _ in range(3):
            self.settle()
            self.taken += self.device.from_host.drain(1 << 30)
        self.settle()
        assert self.host.received == self.sent
        assert all(len(statuses) == 1 for _, statuses in self.writes)
        taken = bytes(self.taken).replace(BREAK, b"")
        for data, (status,) in self.writes:
            if status == 0:
                assert taken.startswith(data)
                taken = taken[len(data) :]
            else:
                assert status == UNLINKED
                size = (
                    next((at for at, byte in enumerate(taken) if byte != data[0]), len(taken)) if data else 0
                )
                assert size <= len(data)
                taken = taken[size:]
        assert taken == b""


Flow.TestCase.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)
TestFlow = Flow.TestCase


def test_what_is_left_of_an_unlinked_transfer_is_lost() -> None:
    """A transfer that is half taken and unlinked leaves no rest for the next."""
    device = CdcAcm(Descriptors(ADAPTER, "s"))
    endpoint = device.from_host
    for seqnum, data in ((1, b"aaaa"), (2, b"bb")):
        endpoint.submit(Submit(seqnum, 2, False, 0, len(data), b"", data))
    assert endpoint.drain(3) == b"aaa"
    assert endpoint.unlink(1)
    assert endpoint.drain(3) == b"bb"
