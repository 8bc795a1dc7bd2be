"""Program of the relay board: commands that end with CR, and a thermostat each 100 ms."""

from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main

TICK_NS = 100_000_000


class RelayBoard:
    """One power-up."""

    def __init__(self, board: Board) -> None:
        self._board, self._uart, self.fields = board, board.uart, board.fields
        self._line = b""

    def main(self) -> Main:
        """Run the board's loop: commands as they come, the thermostat each 100 ms."""
        due_ms = 0
        while True:
            left_ns = max(0, (due_ms - self._board.millis()) * 1_000_000)
            if left_ns and (yield ByteAvailable(timeout_ns=left_ns)):
                self._receive()
            if self._board.millis() >= due_ms:
                due_ms += 100
                self._regulate()

    def _receive(self) -> None:
        for byte in self._uart.read_all():
            if byte != 0x0D:
                self._line += bytes((byte,))
                continue
            self._uart.write(self._answer(self._line.decode("ascii", "replace")).encode() + b"\r\n")
            self._line = b""
        self._line = self._line[-64:]

    def _answer(self, line: str) -> str:
        if line == "?":
            now = self.fields
            return f"{now['temperature_degC']:.1f} heater {now['heater']} fan {now['fan']}"
        name, _, value = line.partition(" ")
        if name in ("heater", "fan") and value in ("0", "1"):
            self._switch(name, int(value))
            return "ok"
        return "what?"

    def _regulate(self) -> None:
        if self.fields["temperature_degC"] > self.fields["limit_degC"]:
            self._switch("heater", 0)

    def _switch(self, name: str, level: int) -> None:
        if self.fields[name] != level:
            self.fields[name] = level
            self.fields["switched"] += 1

    def interrupt(self, event: CoreEvent) -> None:
        """Ignore the core's events: this board has none."""
