"""Framings of lines by name: those of boards, and those that belong to no board."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from hil.config import Catalogue, ConfigError
from hil.discovery.named_kinds import find_buses
from hil.vocab.framing import Framing
from hil.vocab.line_format import EIGHT_N_1, FORMATS, LineFormat
from hil.vocab.profile import Profile

if TYPE_CHECKING:
    from hil.config.segment_model import SegmentConfig


class Framings(Mapping[str, Framing]):
    """Framings by name. Boards are imported only when one is asked for that belongs to no protocol."""

    def __init__(self, boards: Mapping[str, Profile]) -> None:
        self._boards = boards

    def __getitem__(self, name: str) -> Framing:
        return _common()[name] if name in _common() else self._of_boards[name]

    @property
    def _of_boards(self) -> dict[str, Framing]:
        framings = filter(None, map(self._of_board, self._boards))
        return {framing.name: framing for framing in framings}

    def _of_board(self, board: str) -> Framing | None:
        try:
            return self._boards[board].framing
        except ConfigError:  # reported at the key that names the board
            return None

    def __iter__(self) -> Iterator[str]:
        return iter(self._of_boards | _common())

    def __len__(self) -> int:
        return len(self._of_boards | _common())


def _common() -> dict[str, Framing]:
    """Framings that belong to no board; most benches have no line."""
    from hil.wire.bytes_framing import BYTES

    return {framing.name: framing for framing in (*_in(EIGHT_N_1), BYTES)}


def _in(line_format: LineFormat) -> list[Framing]:
    """Framings of the nodes of all kinds, on a line of a format."""
    return [bus.nodes.framing(line_format) for bus in find_buses()[0] if bus.nodes]


def in_format(framing: Framing, line_format: LineFormat) -> Framing:
    """Framing on a line of this format: of those that are told apart by silence another one."""
    return dict(zip(_in(EIGHT_N_1), _in(line_format), strict=True)).get(framing, framing)


def framing_of(config: "SegmentConfig", boards: Iterable[Framing | None], catalogue: Catalogue) -> Framing:
    """Find the framing of a line: that of its nodes or of its format, what a tap says, the first of the
    ``boards`` on it that says one, or bytes."""
    for kind in catalogue.node_kinds:
        if getattr(config, kind.key) or (kind.has_other_formats and config.format != EIGHT_N_1.name):
            return kind.framing(FORMATS[config.format])
    if said := next((tap.framing for tap in config.taps.values() if tap.framing), None):
        return catalogue.framings[said]
    if found := next(filter(None, boards), None):
        return found
    from hil.wire.bytes_framing import BYTES

    return BYTES
