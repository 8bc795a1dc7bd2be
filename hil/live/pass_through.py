"""A real board behind its serial port, and the port at which programs reach it through the daemon.

Nothing here has simulated time: a real board's bytes come when they come. Bytes pass both ways as they are,
unless a fault was asked for; a dialogue of the daemon's own with the board holds the program's bytes up, and
so does a run that has the board as an axis, from its start to its end.
"""

import asyncio
from contextlib import suppress
from typing import Literal

from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Result, Send
from hil.vocab.faults import Fault
from hil.vocab.ports import Port, Tap
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.wire.byte_faults import ByteFaults, apply_all, byte_fault

Towards = Literal["board", "client"]
HOLD_BYTES = 64 * 1024
"""While more than this waits to be taken at one end, nothing is read at the other."""


class _Way:
    """One direction: from a port, of which this is the host, to the other one."""

    def __init__(self, owner: "PassThrough", towards: Towards, source: Port, target: Port) -> None:
        self._owner = owner
        self._towards = towards
        self._source, self._target = source, target
        self._held = False
        self.faults: dict[int, ByteFaults] = {}
        """By the number that each was injected under; they act one after the other."""
        self._free_s = 0.0
        self._waiting = 0

    # ---- PortHost ----

    def room(self) -> int:
        is_busy = self._towards == "board" and (self._owner.is_talking or self._owner.is_held)
        room = 0 if is_busy else HOLD_BYTES - self._target.backlog() - self._waiting
        self._held = room <= 0
        return max(room, 0)

    def received(self, data: bytes) -> None:
        if self._towards == "board":
            self._owner.typed_bytes += len(data)
        self.carry(data)

    def carry(self, data: bytes) -> None:
        """Bytes to the target, through the faults."""
        if not self.faults and not self._waiting:
            self._pass(data)
            return
        loop = asyncio.get_running_loop()
        for delay_ns, piece in apply_all(self.faults.values(), data):
            self._free_s = max(self._free_s, loop.time() + delay_ns / 1e9)
            if delay_ns == 0 and not self._waiting:
                self._pass(piece)
            else:
                self._waiting += len(piece)
                loop.call_at(self._free_s, self._pass_late, piece)

    def _pass_late(self, data: bytes) -> None:
        self._waiting -= len(data)
        self._pass(data)
        self.resume()

    def _pass(self, data: bytes) -> None:
        for tap in self._owner.taps:
            tap(self._towards, data)
        if self._towards == "client":
            self._owner.heard(data)
        self._target.write(data)

    def drained(self) -> None:
        """The source's own backlog has gone: the other way may go on."""
        self._owner.resume()

    def client_left(self, baud: int | None) -> None:
        """The board's line keeps its speed, and the board its power."""

    def port_failed(self, reason: str) -> None:
        self._owner.failures[self._towards] = reason

    def resume(self) -> None:
        if self._held and self.room():
            self._source.resume_reading()


class PassThrough:
    """``client`` and ``board`` are opened with ``to_board`` and ``to_client`` as their hosts."""

    def __init__(self, name: str, client: Port, board: Port) -> None:
        self.name = name
        self.client, self.board = client, board
        self.to_board = _Way(self, "board", client, board)
        self.to_client = _Way(self, "client", board, client)
        self.taps: list[Tap] = []
        """Called with all that passes, after faults: which way, and the bytes."""
        self.failures: dict[str, str] = {}
        self.typed_bytes = 0
        """Those of programs to the board: after them the daemon does not know what it does."""
        self.is_held = False
        """A run has the board."""
        self._talk = asyncio.Lock()
        self._heard: asyncio.Queue[tuple[float, bytes]] | None = None

    @property
    def is_talking(self) -> bool:
        """A dialogue has the board: the client's bytes wait."""
        return self._heard is not None

    def exchange_board(self, board: Port) -> None:
        """Another board's line, which is opened next; faults were the old one's."""
        self.board = self.to_board._target = self.to_client._source = board
        self.to_board.faults.clear()
        self.to_client.faults.clear()
        self.failures.clear()

    def inject(self, number: int, fault: Fault) -> None:
        """Put a fault of the layer ``byte`` on one direction, under a number."""
        delay_ns = round(float(fault.parameters.get("delay_ms", 0)) * NS_PER_MS)
        effect = byte_fault(fault.kind, fault.number("rate"), delay_ns)
        way = self.to_board if fault.parameters["towards"] == "board" else self.to_client
        way.faults[number] = ByteFaults(effect, int(fault.number("seed")))

    def clear(self, number: int) -> None:
        """The line is as it was without that fault."""
        for way in (self.to_board, self.to_client):
            way.faults.pop(number, None)

    def changed_bytes(self, number: int) -> int:
        """How many bytes did not come through as they were."""
        ways = (self.to_board, self.to_client)
        return sum(way.faults[number].changed_bytes for way in ways if number in way.faults)

    def heard(self, data: bytes) -> None:
        """The board sends; clients get it too."""
        if self._heard is not None:
            self._heard.put_nowait((asyncio.get_running_loop().time(), data))

    def resume(self) -> None:
        self.to_board.resume()
        self.to_client.resume()

    def hold(self, is_held: bool) -> None:
        """Programs' bytes for the board wait from now on, or go on."""
        self.is_held = is_held
        self.resume()

    def send(self, data: bytes) -> None:
        """Bytes to the board, as a client's.

        Raises:
            DialogueError: a run has the board.
        """
        if self.is_held:
            raise DialogueError(f"{self.name}: a run has this board; cancel it, or wait for its end")
        self.to_board.received(data)

    async def talk(self, dialogue: Dialogue[Result]) -> Result:
        """Carry out a dialogue with the board; one at a time.

        Raises:
            DialogueError: the board is away, or did not answer as it should.
        """
        async with self._talk:
            self._heard = asyncio.Queue()
            try:
                answer: Heard | None = None
                while True:
                    step = dialogue.send(answer)
                    answer = None
                    if isinstance(step, Send):
                        if not self.board.stats().clients:
                            raise DialogueError(f"{self.name}: {self.board.address} is away")
                        self.to_board.carry(step.data)
                    elif isinstance(step, Listen):
                        answer = await self._listen(self._heard, step.timeout_ns)
            except StopIteration as done:
                result: Result = done.value
                return result
            finally:
                dialogue.close()
                self._heard = None
                self.resume()

    async def _listen(self, heard: "asyncio.Queue[tuple[float, bytes]]", timeout_ns: int) -> Heard:
        at_s, data = 0.0, b""
        if timeout_ns > 0:
            with suppress(TimeoutError):
                async with asyncio.timeout(timeout_ns / 1e9):
                    at_s, data = await heard.get()
        else:
            await asyncio.sleep(0)
        return Heard(SimTimeNs(round((at_s or asyncio.get_running_loop().time()) * 1e9)), data)
