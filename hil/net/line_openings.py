"""Openings of a port's line, told to a host that hears of them."""

from hil.vocab.ports import LineHost


def tell_opened(host: object) -> None:
    """Tell a host that its line was opened, if it hears that."""
    if isinstance(host, LineHost):
        host.line_opened()


class Opening:
    """Opening that is told later, and before the bytes that follow it."""

    def __init__(self) -> None:
        self._is_untold = False

    def begin(self) -> None:
        """Note that the line was opened."""
        self._is_untold = True

    def tell(self, host: object) -> None:
        """Tell a host of it, once."""
        if self._is_untold:
            self._is_untold = False
            tell_opened(host)
