"""Inputs of a bench as lines, for another process that has the same bench."""

from hil.sim.inputs import CommitDone, Logged, encode_line


def as_lines(inputs: list[Logged]) -> list[str]:
    """Write inputs for the other side; what a memory answers at once it answers there itself."""
    return [encode_line(each) for each in inputs if not _is_note(each)]


def _is_note(logged: Logged) -> bool:
    return isinstance(logged.input, CommitDone) and logged.input.at_once
