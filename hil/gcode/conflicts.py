"""Words of one line that do not go together, and words that nothing in it takes."""

from collections.abc import Iterator
from typing import NamedTuple

from hil.gcode.block import Block, CodeWord
from hil.gcode.expressions import WHOLE, Mistake
from hil.gcode.state import SYSTEMS, ProgramState

_ARCS = ("G2", "G3")
_TAKES_AXES = ("G10", "G28", "G30", "G92")
_TAKERS = {
    "i": "G2 or G3",
    "j": "G2 or G3",
    "k": "G2 or G3",
    "r": "G2 or G3",
    "p": "G2, G3, G4, G10 or G64",
    "l": "G10",
    "q": "G64",
}


class Intent(NamedTuple):
    """Motion that a line does: ``G0`` to ``G3``, or none, and the index of the word that asks for it."""

    motion: str | None
    at: int


def intent_of(block: Block, state: ProgramState) -> Intent:
    """Motion that a line does: that of its own word, or of the motion mode."""
    explicit, one_shot = block.codes.get("motion"), block.codes.get("one-shot")
    if one_shot and one_shot.word.name in _TAKES_AXES:
        return Intent(None, one_shot.at)
    if explicit:
        return Intent(explicit.word.name, explicit.at)
    if off := block.codes.get("motion off"):
        return Intent(None, off.at)
    letters = block.axes or ("ijk" if state.motion in _ARCS else "")
    indices = [block.indices[letter] for letter in letters if letter in block.indices]
    return Intent(state.motion, min(indices)) if indices else Intent(None, 0)


def conflicts(block: Block, intent: Intent, state: ProgramState, *, is_in_doubt: bool) -> Iterator[Mistake]:
    """Find what does not go together. ``is_in_doubt``: a problem before may have hidden the motion mode."""
    explicit, one_shot = block.codes.get("motion"), block.codes.get("one-shot")
    takes_axes = one_shot is not None and one_shot.word.name in _TAKES_AXES
    if explicit and one_shot and takes_axes:
        both = f"{one_shot.word.name} and {explicit.word.name}"
        yield Mistake(max(one_shot.at, explicit.at), f"{both} both take the axis words", "make two lines")
    elif block.axes and not takes_axes and intent.motion is None and not is_in_doubt:
        index = min(block.indices[letter] for letter in block.axes)
        if "motion off" in block.codes:
            yield Mistake(index, "G80 ends motion, and there are axis words", "remove G80, or the axis words")
        else:
            yield Mistake(index, "axis words without a motion", "write G0, G1, G2 or G3 before")
    if one_shot:
        yield from _one_shot(one_shot, block, intent, state)
    yield from _untaken(block, intent, one_shot)


def _one_shot(code: CodeWord, block: Block, intent: Intent, state: ProgramState) -> Iterator[Mistake]:
    name = code.word.name
    p = block.numbers.get("p")
    if name == "G4" and (p is None or p < 0):
        at = code.at if p is None else block.indices["p"]
        yield Mistake(
            at, "G4 has no time" if p is None else f"G4 waits {p:g} s", "write the seconds: G4 P1.5"
        )
    elif name == "G92" and not block.axes:
        yield Mistake(code.at, "G92 has no axis words", "write what the axes' numbers are: G92 X0 Y0")
    elif name == "G53":
        if intent.motion not in ("G0", "G1"):
            yield Mistake(code.at, "G53 is without a line", "write G53 G0 or G53 G1, and axis words")
        distance = block.codes.get("distance")
        if distance.word.name == "G91" if distance else state.is_incremental:
            yield Mistake(code.at, "G53 takes places, and G91 asks for distances", "write G90")
    elif name == "G10":
        level = block.numbers.get("l")
        if level not in (2, 20):
            remedy = "write G10 L2 (an origin) or G10 L20 (where the axes are)"
            yield Mistake(block.indices.get("l", code.at), "G10 has no L2 or L20", remedy)
        if p is None or abs(p - round(p)) > WHOLE or not 0 <= round(p) <= len(SYSTEMS):
            remedy = f"P is 1 to {len(SYSTEMS)}, or 0 for the one in use"
            yield Mistake(block.indices.get("p", code.at), "G10 names no coordinate system", remedy)


def _untaken(block: Block, intent: Intent, one_shot: CodeWord | None) -> Iterator[Mistake]:
    is_arc = intent.motion in _ARCS
    path = block.codes.get("path")
    takers = {letter: is_arc for letter in "ijkr"}
    takers["l"] = one_shot is not None and one_shot.word.name == "G10"
    takers["q"] = path is not None and path.word.name == "G64"
    of_p = [
        name
        for name, takes in (
            (intent.motion, is_arc),
            ("G64", takers["q"]),
            (one_shot.word.name if one_shot else "", one_shot and one_shot.word.name in ("G4", "G10")),
        )
        if takes
    ]
    takers["p"] = bool(of_p)
    for letter, is_taken in takers.items():
        if letter in block.numbers and not is_taken:
            name = letter.upper()
            yield Mistake(
                block.indices[letter], f"nothing takes {name}", f"{_TAKERS[letter]} would: remove {name}"
            )
    if "p" in block.numbers and len(of_p) > 1:
        yield Mistake(block.indices["p"], f"{' and '.join(map(str, of_p))} both take P", "make two lines")
