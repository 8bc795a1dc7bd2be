"""Real boards' lines, each behind a port at which programs reach the board through the daemon.

Nothing here has simulated time: a real board's bytes come when they come. Bytes pass both ways as they are,
unless a fault was asked for; a dialogue of the daemon's own with the board holds the program's bytes up, and
so does a run that has the board as an axis, from its start to its end.
"""

import asyncio
from collections.abc import Callable
from contextlib import suppress

from hil.live.port_link import BACKLOG_HOLD_BYTES, PortLink
from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Result, Send
from hil.vocab.faults import Fault
from hil.vocab.ports import Port
from hil.vocab.time import NS_PER_S, SimTimeNs
from hil.wire.byte_faults import ByteFaults, apply_all, byte_faults


class _Way:
    """Bytes in one direction, through its faults. ``moved``: called when waiting bytes are passed on."""

    def __init__(self, passed: Callable[[bytes], None], moved: Callable[[], None]) -> None:
        self._passed = passed
        self._moved = moved
        self.faults: dict[int, ByteFaults] = {}
        """Faults by the numbers they were injected under; they act one after the other."""
        self.waiting_bytes = 0
        self._free_s = 0.0

    def carry(self, data: bytes) -> None:
        # What waits goes first, also when the fault that has delayed it is over.
        if not self.faults and not self.waiting_bytes:
            self._passed(data)
            return
        loop = asyncio.get_running_loop()
        for delay_ns, piece in apply_all(self.faults.values(), data):
            self._free_s = max(self._free_s, loop.time() + delay_ns / NS_PER_S)
            if delay_ns == 0 and not self.waiting_bytes:
                self._passed(piece)
            else:
                self.waiting_bytes += len(piece)
                loop.call_at(self._free_s, self._pass_late, piece)

    def _pass_late(self, data: bytes) -> None:
        self.waiting_bytes -= len(data)
        self._passed(data)
        self._moved()


class BoardBackend:
    """Backend at a real board. ``line`` is the board's own port, opened with ``from_board`` as its host."""

    def __init__(self, link: "PortLink[BoardBackend]", line: Port) -> None:
        self._link = link
        self.name = link.label
        self.line = line
        self.failure: str | None = None
        """Reason why the board's line cannot go on."""
        self.from_board = _FromBoard(self)
        self._to_board = _Way(self._pass_to_board, link.refresh)
        self.to_client = _Way(self._pass_to_client, self.from_board.resume)
        self.typed_bytes = 0
        """Number of bytes from programs to the board: after them the daemon does not know what it does."""
        self.is_held = False
        """True while a run has the board."""
        self._is_gone = False
        self._talk = asyncio.Lock()
        self._heard: asyncio.Queue[tuple[float, bytes]] | None = None

    @property
    def is_busy(self) -> bool:
        """True while a dialogue or a run has the board: clients' bytes wait."""
        return self._heard is not None or self.is_held

    # ---- Backend ----

    def room(self) -> int:
        if self.is_busy:
            return 0
        return max(BACKLOG_HOLD_BYTES - self.line.backlog() - self._to_board.waiting_bytes, 0)

    def hold(self, is_held: bool) -> None:
        """Ignored: the board's line says when there is room again."""

    def feed(self, data: bytes) -> None:
        self.typed_bytes += len(data)
        self._to_board.carry(data)

    def refresh(self) -> None:
        self._link.refresh()
        self.from_board.resume()

    def client_left(self, baud: int | None) -> None:
        """Ignored: the board's line keeps its speed, and the board its power."""

    def leave(self) -> None:
        self._is_gone = True

    def _pass_to_board(self, data: bytes) -> None:
        if not self._is_gone:
            self._link.tell("board", data)
            self.line.write(data)

    # ---- from the board ----

    def room_for_board(self) -> int:
        """Number of the board's bytes that can be taken now."""
        return max(BACKLOG_HOLD_BYTES - self._link.port.backlog() - self.to_client.waiting_bytes, 0)

    def _pass_to_client(self, data: bytes) -> None:
        if self._is_gone:
            return
        if self._heard is not None:
            self._heard.put_nowait((asyncio.get_running_loop().time(), data))
        self._link.send(data)

    # ---- faults ----

    def inject(self, number: int, fault: Fault) -> None:
        """Put a fault of the layer ``byte`` on one direction, under a number."""
        way = self._to_board if fault.parameters["towards"] == "board" else self.to_client
        way.faults[number] = byte_faults(fault)

    def clear(self, number: int) -> None:
        """Take that fault off the line."""
        for way in (self._to_board, self.to_client):
            way.faults.pop(number, None)

    def changed_bytes(self, number: int) -> int:
        """Number of bytes that did not come through as they were."""
        ways = (self._to_board, self.to_client)
        return sum(way.faults[number].changed_bytes for way in ways if number in way.faults)

    # ---- the daemon's own ----

    def hold_clients(self, is_held: bool) -> None:
        """Let programs' bytes for the board wait from now on, because a run has it, or go on."""
        self.is_held = is_held
        self.refresh()

    def send(self, data: bytes) -> None:
        """Send bytes to the board, as a client's. Raises DialogueError: a run has the board."""
        if self.is_held:
            raise DialogueError(f"{self.name}: a run has this board; cancel it, or wait for its end")
        self.feed(data)

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
                        if not self.line.stats().clients:
                            raise DialogueError(f"{self.name}: {self.line.address} is away")
                        # Through the line's faults, as a client's bytes.
                        self._to_board.carry(step.data)
                    elif isinstance(step, Listen):
                        answer = await self._listen(self._heard, step.timeout_ns)
            except StopIteration as done:
                result: Result = done.value
                return result
            finally:
                dialogue.close()
                self._heard = None
                self.refresh()

    async def _listen(self, heard: "asyncio.Queue[tuple[float, bytes]]", timeout_ns: int) -> Heard:
        at_s, data = 0.0, b""
        if timeout_ns > 0:
            with suppress(TimeoutError):
                async with asyncio.timeout(timeout_ns / NS_PER_S):
                    at_s, data = await heard.get()
        else:
            await asyncio.sleep(0)
        return Heard(SimTimeNs(round((at_s or asyncio.get_running_loop().time()) * NS_PER_S)), data)


class _FromBoard:
    """Host of a board's line."""

    def __init__(self, backend: BoardBackend) -> None:
        self._backend = backend
        self._is_held = False

    def room(self) -> int:
        room = self._backend.room_for_board()
        self._is_held = room == 0
        return room

    def received(self, data: bytes) -> None:
        self._backend.to_client.carry(data)

    def drained(self) -> None:
        self._backend.refresh()

    def client_left(self, baud: int | None) -> None:
        """Note that the board is away; its line tries again."""

    def port_failed(self, reason: str) -> None:
        self._backend.failure = reason

    def resume(self) -> None:
        """Read on if the line was held up and there is room again."""
        if self._is_held and self.room():
            self._backend.line.resume_reading()
