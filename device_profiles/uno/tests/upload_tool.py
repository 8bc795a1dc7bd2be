"""Tool that uploads, as avrdude does, at a bench's port in simulated time."""

from typing import Any

from hil.sketch.chip import PAGE_BYTES

IN_SYNC, OK, FAILED = b"\x14", b"\x10", b"\x11"
FLASH, EEPROM = b"F", b"E"


class NotAnswered(Exception):
    """Error of a command that was not answered as it should be: the answer."""


class UploadTool:
    """Tool at an open port."""

    def __init__(self, port: Any) -> None:
        self.port = port

    def sync(self, tries: int = 5) -> None:
        """Get in step: 30h 20h until it is answered, as after an opening."""
        for _ in range(tries):
            self.port.write(b"0 ")
            if self.port.read(2) == IN_SYNC + OK:
                return
        raise NotAnswered(b"")

    def ask(self, command: bytes, count: int = 0, end: bytes = OK) -> bytes:
        """Give a command without its last byte; answers so many bytes."""
        self.port.write(command + b" ")
        answer: bytes = self.port.read(count + 2)
        if answer[:1] != IN_SYNC or answer[-1:] != end or len(answer) != count + 2:
            raise NotAnswered(answer)
        return answer[1:-1]

    def seek(self, at: int) -> None:
        self.ask(b"U" + (at // 2).to_bytes(2, "little"))

    def write_page(self, at: int, data: bytes, kind: bytes = FLASH, end: bytes = OK) -> None:
        self.seek(at)
        self.ask(b"d" + len(data).to_bytes(2, "big") + kind + data, end=end)

    def read_page(self, at: int, count: int, kind: bytes = FLASH, end: bytes = OK) -> bytes:
        self.seek(at)
        return self.ask(b"t" + count.to_bytes(2, "big") + kind, count, end)

    def read(self, count: int) -> bytes:
        """Read the flash from 0 on."""
        pages = range(0, count, PAGE_BYTES)
        return b"".join(self.read_page(at, min(PAGE_BYTES, count - at)) for at in pages)

    def write(self, data: bytes) -> None:
        """Write the flash from 0 on."""
        for at in range(0, len(data), PAGE_BYTES):
            self.write_page(at, data[at : at + PAGE_BYTES])

    def leave(self) -> None:
        self.ask(b"Q")
