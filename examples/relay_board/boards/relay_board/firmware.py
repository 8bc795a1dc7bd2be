"""Program of the relay board: commands that end with CR, and a thermostat each 100 ms."""

from hil.firmware.board_handlers import BoardHandlers

MOST_BYTES = 64
"""Bytes of a line that it keeps."""


class RelayBoard(BoardHandlers):
    """One power-up."""

    TICK_NS = 100_000_000

    def setup(self) -> None:
        self._line = b""

    def received(self, uart: str, data: bytes) -> None:
        *lines, self._line = (self._line + data).split(b"\r")
        self._line = self._line[-MOST_BYTES:]
        for line in lines:
            answer = self._answer(line.decode("ascii", "replace"))
            self.board.uarts[uart].write(answer.encode() + b"\r\n")

    def tick(self) -> None:
        if self.fields["temperature_degC"] > self.fields["limit_degC"]:
            self._switch("heater", 0)

    def _answer(self, line: str) -> str:
        if line == "?":
            now = self.fields
            return f"{now['temperature_degC']:.1f} heater {now['heater']} fan {now['fan']}"
        name, _, value = line.partition(" ")
        if name in ("heater", "fan") and value in ("0", "1"):
            self._switch(name, int(value))
            return "ok"
        return "what?"

    def _switch(self, name: str, level: int) -> None:
        if self.fields[name] != level:
            self.fields[name] = level
            self.fields["switched"] += 1
