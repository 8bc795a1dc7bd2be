"""Master of a line of nodes that a profile describes, without I/O."""

from collections import deque
from collections.abc import Callable, Iterable, Sequence

from hil.master.sans_io.line_turns import LineTiming, LineTurns
from hil.master.sans_io.node_rows import NodeEvent, NodeRow
from hil.master.sans_io.transaction import Outcome, Transaction
from hil.vocab.framing import Item
from hil.vocab.line_node import LineNodes, LinePacket, Signal
from hil.vocab.time import SimTimeNs

TRIES = 3
GAP_CHARACTERS = 1
"""Characters that the master leaves between packets: drivers of nodes need a moment to go off."""
EVENTS_KEPT = 10_000
LATE = 10
"""Multiple of the latency by which an answer to a scan may be late."""
Ended = Callable[[Transaction], None]


class NodeMaster:
    """Master of one line. Times are nanoseconds of one clock; a call's time is never before that of the call
    before.

    ``latency_ns``: maximum delay of what lies between this program and the line, there and back: 0 in
    simulated time. ``tries``: how often a packet goes out at most. ``rest_ns``: time behind a time-out in
    which a late answer still counts, and the node gets nothing else; None: as long as a node can be busy.
    ``has_bit_times``: False where answers may come at once, as from a program at a pty.

    Long because its orders (send, text, release, stop, scan) share the rule that nothing goes out twice.
    """

    def __init__(
        self,
        nodes: LineNodes,
        *,
        baud: int | None = None,
        latency_ns: int = 0,
        tries: int = TRIES,
        rest_ns: int | None = None,
        has_bit_times: bool = True,
    ) -> None:
        self.nodes = nodes
        self.baud = baud or nodes.baud
        self.tries = tries
        bits = nodes.character_bits
        one_ns = bits * 1_000_000_000 // self.baud
        self.timing = LineTiming(
            self.baud,
            bits,
            latency_ns,
            nodes.turnaround_characters * one_ns,
            GAP_CHARACTERS * one_ns,
            nodes.signal_bytes,
            nodes.answer_bytes - 1,
            has_bit_times=has_bit_times,
        )
        self.rest_ns = (nodes.busy_ns if rest_ns is None else rest_ns) + latency_ns
        self.table: dict[int, NodeRow] = {}
        """Row of each node that was spoken to or heard, by its address."""
        self.tells_all = False
        """True if all nodes were told to tell when commands begin and end."""
        self.garbled = 0
        """Number of items on the line that were no packets, or whose checksum was wrong."""
        self._turns = LineTurns(self.timing, lambda unit: unit in self.table and self.table[unit].tells)
        self._splitter = nodes.framing.splitter()
        self._events: deque[NodeEvent] = deque(maxlen=EVENTS_KEPT)

    # ---- what is asked for ----

    def send(
        self,
        node: int,
        command: bytes,
        at_ns: int,
        *,
        tries: int | None = None,
        rest_ns: int | None = None,
        is_urgent: bool = False,
        may_repeat: bool | None = None,
        ended: Ended | None = None,
    ) -> Transaction:
        """Send a command to a node, or to all. It goes out in its turn. ``may_repeat``: for one that knows
        better than the profile whether twice is as good as once.

        Raises:
            ValueError: no node has this address, or no packet can carry the command.
        """
        nodes = self.nodes
        is_to_all = node == nodes.to_all
        frame = nodes.encode(node, command)
        transaction = Transaction(
            node,
            command,
            frame,
            0 if is_to_all else nodes.answer_bytes,
            nodes.may_repeat(command) if may_repeat is None else may_repeat,
            tries or self.tries,
            is_urgent,
            self.rest_ns if rest_ns is None else rest_ns,
            nodes.moves(command),
            self._noting(ended),
        )
        if not is_to_all:
            self._row(node)
        self._turns.add(transaction, at_ns)
        self.advance(at_ns)
        return transaction

    def text(self, node: int, words: str, at_ns: int, ended: Ended | None = None) -> Transaction:
        """Send words for people. Raises ValueError, as ``send``."""
        return self.send(node, self.nodes.text(words), at_ns, ended=ended)

    def release(self, at_ns: int, ended: Ended | None = None) -> Transaction:
        """Let all motions begin that wait for the sync. Goes out when all before it is known."""
        return self.send(self.nodes.to_all, self.nodes.release, at_ns, ended=ended)

    def stop(
        self, nodes: Iterable[int], at_ns: int, *, is_at_once: bool = False, ended: Ended | None = None
    ) -> list[Transaction]:
        """Stop all nodes by one packet to all, then each of these so that it answers. What waits is dropped.

        Answers the transactions, that to all first.
        """
        command = self.nodes.stop_at_once if is_at_once else self.nodes.stop_gracefully
        self.cancel(at_ns, "a stop came before it")
        units = (self.nodes.to_all, *nodes)
        return [self.send(unit, command, at_ns, is_urgent=True, ended=ended) for unit in units]

    def scan(
        self, addresses: Sequence[int] | None, at_ns: int, *, tries: int = 1, ended: Ended | None = None
    ) -> list[Transaction]:
        """Ask each address whether a node is there, by a command that changes nothing. A node is there if it
        answers, whatever it answers."""
        asked = self.nodes.addresses if addresses is None else addresses
        rest_ns = self._scan_rest_ns
        return [
            self.send(each, self.nodes.probe, at_ns, tries=tries, rest_ns=rest_ns, ended=ended)
            for each in asked
        ]

    @property
    def _scan_rest_ns(self) -> int:
        """Time for which a late answer to a scan counts: a computer that has much to do is late at times."""
        return min(LATE * self.timing.latency_ns, self.rest_ns)

    def scan_ns(self, addresses: int, there: int, tries: int = 1) -> int:
        """Time of a scan, calculated: packets, turnarounds and time-outs. ``there``: how many answer."""
        timing, size = self.timing, len(self.nodes.encode(self.nodes.addresses[0], self.nodes.probe))
        answered_ns = (
            timing.characters_ns(size + self.nodes.answer_bytes) + timing.turnaround_ns + timing.gap_ns
        )
        silent = addresses - there
        rest_ns = self._scan_rest_ns if silent else 0  # behind the last one
        return there * answered_ns + silent * tries * timing.first_ns(size) + rest_ns

    def cancel(self, at_ns: int, why: str = "cancelled") -> None:
        """Drop what waits, and repeat nothing that is under way."""
        self._turns.cancel(at_ns, why)

    def lose(self, at_ns: int, why: str) -> None:
        """Note that the port has gone."""
        self._turns.lose(at_ns, why)

    @property
    def outstanding(self) -> list[Transaction]:
        """Those that are not over: under way first, then those that wait."""
        return [*self._turns.under_way(), *self._turns.waiting]

    @property
    def is_lost(self) -> bool:
        """True once the port has gone."""
        return self._turns.is_lost

    @property
    def is_idle(self) -> bool:
        return self._turns.is_idle

    # ---- bytes and time ----

    def receive(self, data: bytes, at_ns: int) -> None:
        """Take bytes of the line, the last of which came at ``at_ns``."""
        if not data:
            return
        start_ns = SimTimeNs(max(at_ns - self.timing.characters_ns(len(data)), 0))
        items = self._splitter.burst(data, start_ns, self.baud).items
        ends = self.nodes.framing.ends(data[-1:], None) if items else ()
        self._turns.heard(at_ns, bool(ends))
        for item in items:
            self._take(item, at_ns)
        self.advance(at_ns)

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do; ``FOREVER``: nothing."""
        return self._turns.due_ns()

    def advance(self, now_ns: int) -> None:
        """Do what is due: time-outs, and the next packet."""
        self._turns.advance(now_ns)

    def to_send(self) -> bytes:
        """Bytes that go out now."""
        return self._turns.to_send()

    def take_events(self) -> list[NodeEvent]:
        """Take what nodes said by themselves since the last call, in order; the last ``EVENTS_KEPT``."""
        events = list(self._events)
        self._events.clear()
        return events

    # ---- what comes ----

    def _take(self, item: Item, at_ns: int) -> None:
        packet = self.nodes.read(item)
        if packet is None:
            self.garbled += 1
            return
        if packet.origin == self.nodes.master:
            return  # an echo of what went out
        row = self._row(packet.origin)
        row.seen(at_ns)
        if packet.signal in (Signal.DONE, Signal.REFUSED):
            if packet.destination == self.nodes.master:
                self._answer(packet, row, at_ns)
            return
        if packet.signal is Signal.TEXT:
            row.text = packet.text
        elif packet.signal is Signal.BEGUN:
            row.begins(at_ns)
        elif packet.signal is Signal.ENDED:
            row.ends(at_ns)
        self._tell(at_ns, packet.origin, packet.signal.value, packet.text)

    def _answer(self, packet: LinePacket, row: NodeRow, at_ns: int) -> None:
        is_done = packet.signal is Signal.DONE
        row.refusals += not is_done
        if (taken := self._turns.answered(packet.origin, is_done, at_ns)) is None:
            row.strays += 1
            self._tell(at_ns, packet.origin, "stray", f"{packet.signal.value} to nothing that is under way")
        elif taken.outcome is Outcome.DONE:
            row.round_trip_ns = taken.round_trip_ns

    def _noting(self, ended: Ended | None) -> Ended:
        def note(transaction: Transaction) -> None:
            row = self.table.get(transaction.unit)
            if row:
                row.sent += transaction.sent
                row.lost += transaction.silences
            tells = self.nodes.tells_from(transaction.command)
            if tells is not None and transaction.outcome in (Outcome.DONE, Outcome.SENT):
                self._note_tells(row, tells)
            if ended:
                ended(transaction)

        return note

    def _note_tells(self, row: NodeRow | None, tells: bool) -> None:
        if row:
            row.tells = tells
            return
        self.tells_all = tells
        for each in self.table.values():
            each.tells = tells

    def _tell(self, at_ns: int, node: int, kind: str, text: str) -> None:
        self._events.append(NodeEvent(at_ns, node, kind, text))

    def _row(self, node: int) -> NodeRow:
        if node not in self.table:
            self.table[node] = NodeRow(node, tells=self.tells_all)
        return self.table[node]
