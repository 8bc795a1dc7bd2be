"""Port that is held up: it reads on when there is room again, whoever was the first to see it."""

from typing import cast

from hil.live.port_link import PortLink
from hil.vocab.ports import Port


class OnePort:
    """Reads as a port does: until there is no room, and again when it is told."""

    def __init__(self) -> None:
        self.is_reading = True

    def resume_reading(self) -> None:
        self.is_reading = True

    def looks(self, link: "PortLink[OneEnd]") -> None:
        if link.room() == 0:
            self.is_reading = False


class OneEnd:
    """Backend that can take ``room_bytes`` now; ``comes`` comes just as the port is held up."""

    def __init__(self, link: "PortLink[OneEnd]") -> None:
        self.link = link
        self.room_bytes = 0
        self.comes = 0

    def room(self) -> int:
        return self.room_bytes

    def hold(self, is_held: bool) -> None:
        if is_held and self.comes:
            self.room_bytes = self.comes
            self.link.refresh()

    def feed(self, data: bytes) -> None: ...
    def refresh(self) -> None: ...
    def client_left(self, baud: int | None) -> None: ...
    def leave(self) -> None: ...


def held_up() -> tuple[OnePort, "PortLink[OneEnd]", OneEnd]:
    port = OnePort()
    link: PortLink[OneEnd] = PortLink("m1", cast(Port, port))
    end = OneEnd(link)
    link.occupy(end)
    return port, link, end


def test_room_that_comes_as_the_port_is_held_up_is_not_lost() -> None:
    port, link, end = held_up()
    end.comes = 256
    port.looks(link)
    assert port.is_reading


def test_room_that_somebody_else_sees_first_is_the_ports_too() -> None:
    port, link, end = held_up()
    port.looks(link)
    assert not port.is_reading
    end.room_bytes = 16
    assert link.room() == 16  # as typing beside the port does
    assert port.is_reading
