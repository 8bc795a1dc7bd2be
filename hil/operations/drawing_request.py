"""Messages between the daemon and the process that plans a drawing."""

from collections.abc import Iterable, Mapping, Sequence
from struct import Struct
from typing import NamedTuple

from hil.vocab.axis import AxisNow

WORKER = "hil.operations.drawing_worker"
HEAD = Struct("<?32sQ")
"""Begin of the process's output: whether the drawing may be run, its digest, and the length of the answer,
JSON without its last bracket. Behind the answer is the rest of an object of it and the texts."""


class DrawingRequest(NamedTuple):
    """Request for a drawing of ``axes``. ``is_check``: without its path and its runs."""

    text: str
    machine_text: str
    file: str
    machine_file: str
    feed_percent: float
    axes: Mapping[str, AxisNow]
    is_check: bool = False


def split_at(pieces: Iterable[bytes], at: int) -> tuple[Sequence[bytes], Sequence[bytes]]:
    """Pieces of the first so many bytes, and those of the rest."""
    first, rest = [], []
    for piece in pieces:
        first.append(piece[:at])
        rest.append(piece[at:])
        at = max(at - len(piece), 0)
    return [each for each in first if each], [each for each in rest if each]
