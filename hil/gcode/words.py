"""Every word of RS-274/NGC: what it means, in which modal group it is, and what is done with it here."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

Use = Literal["done", "accepted", "refused"]
Group = Literal[
    "motion",
    "motion off",
    "one-shot",
    "plane",
    "distance",
    "arc distance",
    "feed mode",
    "units",
    "cutter",
    "tool length",
    "coordinates",
    "path",
    "return",
    "spindle mode",
    "lathe",
    "stop",
    "tool change",
    "spindle",
    "coolant",
    "override",
    "pins",
    "no group",
]


class Word(NamedTuple):
    """A G or M word. ``remedy`` says what to do about one that is refused, or what was left out."""

    name: str
    group: Group
    meaning: str
    use: Use = "done"
    remedy: str = ""


_CYCLE = "have the CAM program write its canned cycles as single moves"
_PROBE = "take the probing out: there is no probe here"
_CURVE = "have the CAM program write curves as lines and arcs"
_CUTTER = "have the CAM program compensate the radius in its path"
_LENGTH = "shift Z with G10 L20 or G92, and remove the word"
_SUBROUTINE = "have the CAM program write out what it calls"
_PINS = "remove it: there are no such pins"
_THREAD = "remove it: motion does not follow the spindle's angle"
_OVERRIDE = "the override of the feed stays as it is"

_G = (
    Word("G0", "motion", "rapid"),
    Word("G1", "motion", "straight line with feed"),
    Word("G2", "motion", "arc clockwise: I J K or R, P turns"),
    Word("G3", "motion", "arc counterclockwise: I J K or R, P turns"),
    Word("G80", "motion off", "no motion mode, unless the line has a motion: axis words are mistakes then"),
    Word("G5", "motion", "cubic spline", "refused", _CURVE),
    Word("G5.1", "motion", "quadratic spline", "refused", _CURVE),
    Word("G5.2", "motion", "NURBS begins", "refused", _CURVE),
    Word("G5.3", "motion", "NURBS ends", "refused", _CURVE),
    Word("G33", "motion", "thread", "refused", _THREAD),
    Word("G33.1", "motion", "rigid tapping", "refused", _THREAD),
    Word("G38.2", "motion", "probing", "refused", _PROBE),
    Word("G38.3", "motion", "probing", "refused", _PROBE),
    Word("G38.4", "motion", "probing", "refused", _PROBE),
    Word("G38.5", "motion", "probing", "refused", _PROBE),
    *(
        Word(name, "motion", f"canned cycle: {cycle}", "refused", _CYCLE)
        for name, cycle in (
            ("G73", "drilling with chip breaking"),
            ("G76", "threading"),
            ("G81", "drilling"),
            ("G82", "drilling with a dwell"),
            ("G83", "peck drilling"),
            ("G84", "tapping"),
            ("G85", "boring"),
            ("G86", "boring, spindle stop"),
            ("G87", "back boring"),
            ("G88", "boring, manual out"),
            ("G89", "boring with a dwell"),
        )
    ),
    Word("G70", "motion", "inches in other dialects", "refused", "write G20"),
    Word("G71", "motion", "millimetres in other dialects", "refused", "write G21"),
    Word("G72", "motion", "facing of a lathe", "refused", _CYCLE),
    Word("G4", "one-shot", "dwell of P seconds"),
    Word("G10", "one-shot", "L2: offset of coordinate system P; L20: offset so that the axes are here"),
    Word("G28", "one-shot", "rapid to the place of G28.1, over the point that axis words give"),
    Word("G28.1", "one-shot", "store where the axes are for G28"),
    Word("G30", "one-shot", "rapid to the place of G30.1, over the point that axis words give"),
    Word("G30.1", "one-shot", "store where the axes are for G30"),
    Word("G53", "one-shot", "G0 or G1 of this line in machine coordinates"),
    Word("G92", "one-shot", "call where the axes are by these numbers"),
    Word("G92.1", "one-shot", "offsets of G92 to 0"),
    Word("G92.2", "one-shot", "offsets of G92 off, kept in parameters"),
    Word("G92.3", "one-shot", "offsets of G92 on again"),
    Word("G52", "one-shot", "local offset", "refused", "use G10 L2 or G92"),
    Word("G17", "plane", "plane XY"),
    Word("G18", "plane", "plane XZ"),
    Word("G19", "plane", "plane YZ"),
    Word("G17.1", "plane", "plane UV", "refused", "arcs are in XY, XZ or YZ"),
    Word("G18.1", "plane", "plane WU", "refused", "arcs are in XY, XZ or YZ"),
    Word("G19.1", "plane", "plane VW", "refused", "arcs are in XY, XZ or YZ"),
    Word("G90", "distance", "axis words are places"),
    Word("G91", "distance", "axis words are distances"),
    Word("G90.1", "arc distance", "I J K are places"),
    Word("G91.1", "arc distance", "I J K are distances from the beginning of the arc"),
    Word("G93", "feed mode", "F is how often in a minute the motion could be done: each line needs its own"),
    Word("G94", "feed mode", "F is millimetres, inches or degrees in a minute"),
    Word("G95", "feed mode", "F is for a turn of the spindle"),
    Word("G20", "units", "inches"),
    Word("G21", "units", "millimetres"),
    Word("G40", "cutter", "no compensation of the cutter's radius", "accepted"),
    Word("G41", "cutter", "cutter on the left", "refused", _CUTTER),
    Word("G41.1", "cutter", "cutter on the left", "refused", _CUTTER),
    Word("G42", "cutter", "cutter on the right", "refused", _CUTTER),
    Word("G42.1", "cutter", "cutter on the right", "refused", _CUTTER),
    Word("G43", "tool length", "length of a tool", "refused", _LENGTH),
    Word("G43.1", "tool length", "length of a tool", "refused", _LENGTH),
    Word("G43.2", "tool length", "length of a tool", "refused", _LENGTH),
    Word("G49", "tool length", "no length of a tool", "accepted"),
    Word("G54", "coordinates", "coordinate system 1"),
    Word("G55", "coordinates", "coordinate system 2"),
    Word("G56", "coordinates", "coordinate system 3"),
    Word("G57", "coordinates", "coordinate system 4"),
    Word("G58", "coordinates", "coordinate system 5"),
    Word("G59", "coordinates", "coordinate system 6"),
    Word("G59.1", "coordinates", "coordinate system 7"),
    Word("G59.2", "coordinates", "coordinate system 8"),
    Word("G59.3", "coordinates", "coordinate system 9"),
    Word("G61", "path", "corners exactly"),
    Word("G61.1", "path", "a stop at each corner"),
    Word("G64", "path", "corners blended, by at most P"),
    Word("G98", "return", "canned cycles return to where they began", "accepted"),
    Word("G99", "return", "canned cycles return to R", "accepted"),
    Word("G96", "spindle mode", "constant surface speed", "refused", "give the speed in rpm with S"),
    Word("G97", "spindle mode", "speed in rpm", "accepted"),
    Word("G7", "lathe", "X is a diameter", "refused", "give radii"),
    Word("G8", "lathe", "X is a radius", "accepted"),
)

_M = (
    Word("M0", "stop", "pause"),
    Word("M1", "stop", "pause if the person at the machine wants one"),
    Word("M2", "stop", "end: spindle and coolant off"),
    Word("M30", "stop", "end: spindle and coolant off"),
    Word("M60", "stop", "pause for a change of pallets", "refused", "use M0"),
    Word("M6", "tool change", "spindle off, and a pause: the tool is changed by hand"),
    Word("M61", "tool change", "number of the tool", "refused", "remove it: there is no tool table"),
    Word("M3", "spindle", "spindle clockwise"),
    Word("M4", "spindle", "spindle counterclockwise"),
    Word("M5", "spindle", "spindle off"),
    Word("M19", "spindle", "spindle to an angle", "refused", "remove it"),
    Word("M7", "coolant", "mist on"),
    Word("M8", "coolant", "flood on"),
    Word("M9", "coolant", "mist and flood off"),
    Word("M48", "override", "overrides on", "accepted"),
    Word("M49", "override", "overrides off", "accepted", _OVERRIDE),
    Word("M50", "override", "override of the feed", "refused", "remove it"),
    Word("M51", "override", "override of the spindle", "refused", "remove it"),
    Word("M52", "override", "adaptive feed", "refused", "remove it"),
    Word("M53", "override", "feed hold", "refused", "remove it"),
    *(Word(f"M{number}", "pins", "pins", "refused", _PINS) for number in (62, 63, 64, 65, 66, 67, 68)),
    *(
        Word(f"M{number}", "no group", "modes saved and restored", "refused", "write the modes out")
        for number in (70, 71, 72, 73)
    ),
    Word("M98", "no group", "call of a subroutine", "refused", _SUBROUTINE),
    Word("M99", "no group", "end of a subroutine", "refused", _SUBROUTINE),
)

G_WORDS: Mapping[int, Word] = {round(float(word.name[1:]) * 10): word for word in _G}
"""By ten times the number: 611 is G61.1."""

M_WORDS: Mapping[int, Word] = {int(word.name[1:]): word for word in _M}

LETTERS: Mapping[str, str] = {
    "X Y Z": "end of a motion along the axis, millimetres or inches",
    "A B C": "end of a motion around X, Y, Z, degrees",
    "U V W": "end of a motion along the axis beside X, Y, Z, millimetres or inches",
    "I J K": "centre of an arc along X, Y, Z",
    "R": "radius of an arc; below 0: the longer of two",
    "F": "feed",
    "S": "speed of the spindle, rpm",
    "T": "number of the tool for the next M6",
    "P": "seconds of G4, tolerance of G64, turns of G2 and G3, coordinate system of G10",
    "L": "what G10 sets: 2 or 20",
    "Q": "read with G64, and nothing is done: lines are not joined",
    "N": "number of a line, first in it: any",
}
"""Meanings of the letters beside G and M, for messages."""

REFUSED_LETTERS: Mapping[str, str] = {
    "d": "no word here takes it: the cutter's radius is not compensated",
    "e": "no word here takes it; a number has no exponent: write 1000 for 1e3",
    "h": "no word here takes it: there is no tool table",
}
AXES = "xyzabcuvw"
"""Letters of axes, in the order of a ``Point``."""

PLAIN = "xyzabcuvwijkrfstplqdeh"
"""Letters that may stand once in a line, with a number."""
