"""Link of a UART to its segment, which is told what concerns the sketch."""

from hil.vocab.segment import Receiver, Segment


class StationLink:
    """Link of a UART, the ``receiver``, to its segment, where it is the station of this name."""

    def __init__(self, segment: Segment, name: str, receiver: Receiver) -> None:
        self.segment = segment
        self.name = name
        self.told_address: int | None = None
        self._told_polling = True
        segment.join(name, receiver)

    def tell_address(self, address: int | None) -> None:
        """Let the segment know which packets concern the sketch now."""
        if address != self.told_address:
            self.told_address = address
            self.segment.set_address(self.name, address)

    def tell_polling(self, is_polling: bool) -> None:
        """Let the segment know whether the sketch reads at once what comes."""
        if is_polling != self._told_polling:
            self._told_polling = is_polling
            self.segment.set_polling(self.name, is_polling)
