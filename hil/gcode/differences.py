"""Intended differences of this reader from LinuxCNC's interpreter."""

from typing import Literal, NamedTuple

Does = Literal["refuses", "moves"]


class DialectDifference(NamedTuple):
    """A program, without its end, that both take differently, and why. Two that move, move differently."""

    what: str
    program: str
    ours: Does
    theirs: Does
    why: str


DIFFERENCES = (
    DialectDifference(
        "words for what is not here, as G5, G33, G38.2, G41, G43, G52, G81, G96, M19, M62: see above",
        "G81 X1 Z-1 R1 F100",
        "refuses",
        "moves",
        "a path without them would not be the one that is meant",
    ),
    DialectDifference(
        "O words, M98 and M99: subroutines, loops",
        "M99",
        "refuses",
        "moves",
        "they are not read",
    ),
    DialectDifference(
        "planes of U V W: G17.1, G18.1, G19.1",
        "G19.1",
        "refuses",
        "moves",
        "arcs are in X Y Z",
    ),
    DialectDifference(
        "axis words U V W",
        "G0 U1",
        "moves",
        "refuses",
        "`rs274` refuses them; LinuxCNC itself takes those that its configuration has",
    ),
    DialectDifference(
        "polar words @ and ^",
        "G0 @1 ^45",
        "refuses",
        "moves",
        "they are not of RS-274/NGC",
    ),
    DialectDifference(
        "G92.1, G92.2 or G92.3 beside G4, G10, G28, G30, G53",
        "G92.1 G28",
        "refuses",
        "moves",
        "both are of one modal group, RS-274/NGC, table 4",
    ),
    DialectDifference(
        "one P that two words would take",
        "F100 G64 P2 G2 X1 I0.5",
        "refuses",
        "moves",
        "a tolerance of 2 mm is not two turns",
    ),
    DialectDifference(
        "G10 with R (a rotation), with Q, and for tools (L0, L1, L10, L11)",
        "G10 L2 P1 R45",
        "refuses",
        "moves",
        "arcs in XZ and YZ would be none; there is no tool table",
    ),
    DialectDifference(
        "P of G10 that is not whole",
        "G10 L2 P1.5 X1",
        "refuses",
        "moves",
        "there is no coordinate system 1.5",
    ),
    DialectDifference(
        "G95 while the spindle is off",
        "G95 F1 S100 G1 X1",
        "refuses",
        "moves",
        "nothing would move: the feed is for a turn",
    ),
    DialectDifference(
        "arcs of less than a millionth of a radian, that do not end where they begin",
        "F100 G2 X0.000001 I5",
        "refuses",
        "moves",
        "LinuxCNC makes a whole circle; nothing may be meant",
    ),
    DialectDifference(
        "F0 with G93",
        "G93 F0 G1 X1",
        "refuses",
        "moves",
        "the motion would never end; LinuxCNC takes 0.1",
    ),
    DialectDifference(
        "feeds below a millionth",
        "F0.0000001 G1 X1",
        "refuses",
        "moves",
        "the motion would never end",
    ),
    DialectDifference(
        "numbers from a thousand million on",
        "G0 X1000000000",
        "refuses",
        "moves",
        "no machine is 1000 kilometres long: a point is missing",
    ),
    DialectDifference(
        "a division by 0 whose result a comparison hides",
        "G0 X[0 MOD 0 GT 1]",
        "refuses",
        "moves",
        "a value without a meaning is a mistake wherever it stands",
    ),
    DialectDifference(
        "a parameter with an empty name, or with # < = [ ] in its name",
        "#<> = 1",
        "refuses",
        "moves",
        "a name is missing, or its end",
    ),
    DialectDifference(
        "lines of 254 to 256 characters",
        "G0 X1" + " " * 245 + "Y2345",
        "moves",
        "refuses",
        "RS-274/NGC allows 256",
    ),
    DialectDifference(
        "a CR inside a line",
        "G0 X1\r5",
        "refuses",
        "moves",
        "two lines would become one: X15",
    ),
    DialectDifference(
        "a file that begins with the mark of UTF-8",
        "\ufeffG0 X1",
        "moves",
        "refuses",
        "editors write it, and it changes nothing",
    ),
    DialectDifference(
        "units of parameters 5161 to 5390",
        "#5161 = 10\nG28",
        "moves",
        "moves",
        "they are in the machine's units: millimetres here, inches in `rs274`",
    ),
    DialectDifference(
        "several messages in a line",
        "(MSG, one) (MSG, two)",
        "moves",
        "moves",
        "each is shown; LinuxCNC shows the last one",
    ),
    DialectDifference(
        "comments that print: DEBUG, LOG, PRINT",
        "(DEBUG, #1)",
        "moves",
        "moves",
        "they are comments here",
    ),
)
