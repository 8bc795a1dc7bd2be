"""Master at a port, on this computer's clock."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from hil.master.line_loop import LineLoop
from hil.master.line_place import LinePlace, find_line
from hil.master.line_port import LinePort
from hil.master.sans_io.line_run import How, LineRun
from hil.master.sans_io.node_master import TRIES, NodeMaster
from hil.master.sans_io.node_rows import NodeEvent, NodeRow
from hil.master.sans_io.run_items import RunReport
from hil.master.sans_io.transaction import Outcome, Transaction
from hil.wire.echo import Echo
from hil.wire.sole_senders import sole_by


class LiveMaster(LineLoop):
    """Master whose line is open. Made by ``open_line``."""

    def __init__(self, place: LinePlace, tries: int = TRIES, rest_ns: int | None = None) -> None:
        sole = sole_by(place.nodes.framing, lambda address: False)
        super().__init__(place.name, place.speed, Echo(place.baud, wanted=place.echo, sole=sole))
        self.place = place
        self.master = NodeMaster(
            place.nodes,
            baud=place.baud,
            latency_ns=place.latency_ns,
            tries=tries,
            rest_ns=rest_ns,
            has_bit_times=place.has_bit_times,
        )
        self.listeners: list[Callable[[NodeEvent], None]] = []
        """Called with each event of a node."""
        self._run: LineRun | None = None

    async def open(self) -> None:
        """Open the port. Raises LineUnreachable."""
        place = self.place
        self._port = await LinePort.open(place.address, place.baud, self._received, self._lost, self._echo)
        try:
            await asyncio.to_thread(place.wait_until_heard)
        except BaseException:
            self.close()
            raise

    # ---- asked for ----

    @property
    def table(self) -> dict[int, NodeRow]:
        """Nodes that were heard, by their addresses."""
        return {address: row for address, row in sorted(self.master.table.items()) if row.is_there}

    def start(self, node: int, command: bytes | str, *, is_urgent: bool = False) -> Transaction:
        """Send a command without waiting for its outcome. Raises ValueError, as ``NodeMaster.send``."""
        data = command.encode("latin-1") if isinstance(command, str) else command
        sent = self.master.send(node, data, self.now_ns(), is_urgent=is_urgent)
        self._turn()
        return sent

    async def send(self, node: int, command: bytes | str) -> Transaction:
        """Send a command to a node, or to all (0), and wait for its outcome.

        Raises:
            ValueError: no node has this address, or no packet can carry the command.
            LineGone: the port has gone.
        """
        sent = self.start(node, command)
        await self.settled([sent])
        return sent

    async def text(self, node: int, words: str) -> Transaction:
        """Send words for people. Raises as ``send``."""
        return await self.send(node, self.master.nodes.text(words))

    async def release(self) -> Transaction:
        """Let all motions begin that wait for the sync. Raises LineGone."""
        return await self.send(self.master.nodes.to_all, self.master.nodes.release)

    def start_stop(self, nodes: Iterable[int] = (), *, is_at_once: bool = False) -> list[Transaction]:
        """Begin to stop everybody by a packet to all, then each of these nodes so that it answers; answers
        the transactions, that to all first."""
        sent = self.master.stop(nodes, self.now_ns(), is_at_once=is_at_once)
        self._turn()
        return sent

    async def stop(self, nodes: Iterable[int] = (), *, is_at_once: bool = False) -> list[Transaction]:
        """Stop as ``start_stop``, and wait for the outcomes. Raises LineGone."""
        sent = self.start_stop(nodes, is_at_once=is_at_once)
        await self.settled(sent)
        return sent

    async def scan(self, addresses: Sequence[int] | None = None, tries: int = 1) -> list[NodeRow]:
        """Find the nodes of these addresses, or of all. Raises LineGone, ValueError."""
        asked = self.master.scan(addresses, self.now_ns(), tries=tries)
        self._turn()
        await self.settled(asked)
        return [row for each in asked if (row := self.master.table[each.unit]) and _is_there(each)]

    async def carry_out(self, run: LineRun) -> RunReport:
        """Carry out a run of this master to its end; answers its report, also when the port has gone.

        Its state may be changed meanwhile by ``pause``, ``resume`` and ``stop`` of this line. A cancelled
        task makes a controlled stop first.
        """
        self._run = run
        run.start(self.now_ns())
        self._turn()
        try:
            await self._run_over(run)
        except asyncio.CancelledError:
            self.stop_run("grace")
            await self._run_over(run)
            raise
        finally:
            self._run = None
        return run.report

    async def _run_over(self, run: LineRun) -> None:
        while not run.is_over:
            self._ended.clear()
            await self._ended.wait()

    def pause_run(self) -> None:
        """Pause the run where all its axes rest."""
        if self._run:
            self._run.pause()
            self._turn()

    def resume_run(self) -> None:
        """Let a run that pauses go on."""
        if self._run:
            self._run.resume(self.now_ns())
            self._turn()

    def stop_run(self, how: How = "grace") -> None:
        """Stop the run."""
        if self._run:
            self._run.stop(self.now_ns(), how)
            self._turn()

    # ---- turns ----

    @property
    def _master(self) -> LineRun | NodeMaster:
        return self._run or self.master

    def _outstanding(self) -> Sequence[Transaction]:
        return self.master.outstanding

    def _lost(self, why: str) -> None:
        super()._lost(why)
        self.master.lose(self.now_ns(), f"{self.place.name} has gone")

    def _after_turn(self) -> None:
        for event in self.master.take_events():
            for each in self.listeners:
                each(event)


def _is_there(transaction: Transaction) -> bool:
    return transaction.outcome is Outcome.DONE or transaction.refusals > 0


@asynccontextmanager
async def open_line(
    line: str | LinePlace,
    *,
    baud: int | None = None,
    latency_ns: int | None = None,
    tries: int = TRIES,
    profile: str | None = None,
    echo: bool | None = None,
    bench: str | None = None,
    runtime_dir: Path | None = None,
) -> AsyncIterator[LiveMaster]:
    """Open a line, as ``find_line`` finds it, for the block.

    Raises:
        LineUnreachable: there is no such line, or it cannot be opened.
    """
    place = line
    if isinstance(place, str):
        place = await asyncio.to_thread(
            find_line,
            place,
            baud=baud,
            latency_ns=latency_ns,
            profile=profile,
            echo=echo,
            bench=bench,
            runtime_dir=runtime_dir,
        )
    master = LiveMaster(place, tries)
    await master.open()
    try:
        yield master
    finally:
        master.close()
