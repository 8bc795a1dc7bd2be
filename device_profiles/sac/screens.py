"""Screens of the SAC, byte for byte as the original's screenshots have them; columns by TABs of eight."""

from collections.abc import Iterator, Mapping

from device_profiles.sac.parameters import LEFT, RIGHT, Parameter, Parameters
from hil.vocab.motion import MotionEntry

_RULE = "=" * 70


def queue(entries: Mapping[int, MotionEntry], at: int) -> Iterator[str]:
    """Lines of the queue's listing. ``entries`` by position; ``at``: where the queue is."""
    yield "Q\tSteps\t\tRPM\tCycle\t Acc\tDec\tusteps\t deltaT"
    yield _RULE
    for position, e in entries.items():
        yield (
            f"{position}\t{e.steps}\t{'+' if e.is_pulses else ' '}{'CCW' if e.is_ccw else 'CW'}\t{e.rpm}\t"
            f"{e.cycle_us}\t{'*' if e.is_linear else ' '}{e.acc_hundredths / 100:.2f}\t"
            f"{e.dec_hundredths / 100:.2f}\t{e.extra_pulses}\t{'s ' if e.is_sync else '  '}{e.wait_us}"
        )
    yield _RULE
    yield f"Q is at {at}\t+ pulse \t\t* linear\t\ts sync"


def configuration(parameters: Parameters) -> Iterator[str]:
    """Lines of the configure screen. Row D has a value, 0, without a name; no command sets it."""
    yield "Config:"
    for left, right in zip(LEFT, RIGHT, strict=True):
        line = _column("", 0, left, parameters) if left else _to("D", 16) + "0"
        if right:
            line = _column(_to(line, 24), 24, right, parameters)
        yield line


def _column(line: str, start: int, parameter: Parameter, parameters: Parameters) -> str:
    line = _to(f"{line}{parameter.letter} {parameter.name}", start + 16)
    return line + parameter.show(parameters, getattr(parameters, parameter.field))


def _to(line: str, column: int) -> str:
    """Pad a line with TABs up to a column."""
    while len(line.expandtabs()) < column:
        line += "\t"
    return line


def xref(array: tuple[int, ...]) -> Iterator[str]:
    """Rows of the xRef array, up to and with the 0 that ends it."""
    for index, position in enumerate(array):
        yield f"x_ {index} {position}"
        if position == 0:
            return


def dump(data: bytes) -> Iterator[str]:
    """A hexadecimal dump, 16 bytes a line."""
    for at in range(0, len(data), 16):
        yield f"{at:04X}: " + data[at : at + 16].hex(" ").upper()
