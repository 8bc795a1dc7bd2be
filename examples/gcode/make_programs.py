"""Programs in G-code as CAM programs write them, the same each time, for the mill of ``examples/line``.

``python examples/gcode/make_programs.py`` writes those of this folder; with a name of a file and a number of
lines it writes a larger engraving.
"""

import sys
from collections.abc import Iterator
from math import cos, radians, sin, tau
from pathlib import Path

HERE = Path(__file__).parent
SHORT = 400
"""Lines of the engraving in this folder."""


def engraving(lines: int) -> str:
    """Rosettes, cut in strokes of forty points, with a rapid above the work between them. 70 mm wide."""
    text = ["%", "(rosettes, 70 mm wide)", "G21 G90 G17 G94 G64 P0.02", "T1 M6", "S12000 M3", "G0 Z5"]
    end = ["G0 Z5", "M5", "G0 X0 Y0", "M30", "%"]
    step = 0
    while len(text) < lines - len(end):
        angle, radius = tau * step / 733, 27 + 8 * sin(tau * step / 97)
        x, y = 60 + radius * cos(angle), 40 + radius * sin(angle)
        depth = -0.4 - 0.2 * cos(tau * step / 61)
        match step % 40:
            case 0:
                text.append(f"G0 X{x:.3f} Y{y:.3f}")
            case 1:
                text.append(f"G1 Z{depth:.3f} F120")
            case 2:
                text.append(f"G1 X{x:.3f} Y{y:.3f} F900")
            case 39:
                text.append("G0 Z5")
            case _:
                text.append(f"X{x:.3f} Y{y:.3f}" + (f" Z{depth:.3f}" if step % 3 == 0 else ""))
        step += 1
    return "\n".join([*text, *end, ""])


def arcs() -> str:
    """Arcs of every kind: centres and radii, large and tiny, less and more than a half, whole turns, helices,
    each plane, places and distances, inches."""
    return "\n".join([*_arcs(), ""])


def _arcs() -> Iterator[str]:
    yield from ("(arcs of every kind)", "G21 G90 G17 G91.1 G94 F1200", "G0 X60 Y40 Z15")
    for plane, first, second, i, j in ("G17", *"XYIJ"), ("G18", *"ZXKI"), ("G19", *"YZJK"):
        yield f"({plane}: quarters, halves, wholes)"
        yield f"{plane} G91"
        for word, sign in (("G2", -1), ("G3", 1)):
            for degrees in (1, 45, 90, 179.9, 180, 180.1, 270, 359):
                for radius in (0.05, 4):
                    turn = sign * radians(degrees)
                    one, other = radius * (1 - cos(turn)), -radius * sin(turn)
                    yield f"{word} {first}{one:.6f} {second}{other:.6f} {i}{radius} {j}0"
                    yield f"G0 {first}{-one:.6f} {second}{-other:.6f}"
            yield f"{word} {i}3 {j}1"
            yield f"{word} {i}3 {j}1 P3"
        yield "G90 G0 X60 Y40 Z15"
    yield "(radii: the shorter and the longer arc)"
    yield "G17"
    for word in ("G2", "G3"):
        for radius in (10, -10, 10.5, -10.5, 15, -15):
            yield f"{word} X80 Y40 R{radius}"
            yield "G0 X60 Y40"
    yield "(helices)"
    yield "G3 X60 Y40 Z5 I10 J0 P4 F600"
    yield "G2 X80 Y40 Z15 I10 J0"
    yield "G90.1 (centres as places)"
    yield "G3 X60 Y40 I70 J40"
    yield "G91.1 (and as distances again)"
    yield "G20 (inches)"
    yield "G2 X2.9 Y1.6 I0.26890 J0.01260"
    yield "G21 G0 X60 Y40"
    yield "(a line of tiny arcs)"
    for step in range(60):
        yield f"{'G2' if step % 2 else 'G3'} X{59.5 - step * 0.5:.1f} Y40 I-0.25 J0"
    yield from ("G0 Z15", "M2")


def mixed_units() -> str:
    """The same square in millimetres and in inches, by places and by distances."""
    square = ((50.8, 0.0), (50.8, 50.8), (0.0, 50.8), (0.0, 0.0))
    text = ["(one square four times, in millimetres and inches)", "G17 G94 G90"]
    for units, mm, feed in (("G21", 1.0, 508.0), ("G20", 25.4, 20.0)):
        text += [
            units,
            f"F{feed:g}",
            f"G0 X{25.4 / mm:g} Y{25.4 / mm:g} Z{2.54 / mm:g}",
            f"G1 Z{-2.54 / mm:g}",
        ]
        text += [f"X{(25.4 + x) / mm:g} Y{(25.4 + y) / mm:g}" for x, y in square]
        text.append("G91")
        here = (0.0, 0.0)
        for there in square:
            text.append(f"X{(there[0] - here[0]) / mm:g} Y{(there[1] - here[1]) / mm:g}")
            here = there
        text += ["G90", f"G0 Z{2.54 / mm:g}"]
    return "\n".join([*text, "G21", "M30", ""])


def expressions() -> str:
    """A ring of places, by parameters and expressions."""
    text = [
        "(six dimples on a ring; the ring stands in two parameters)",
        "G21 G90 G94 G17",
        "#<radius> = 25",
        "#<depth> = -1.5",
        "#1 = 0 (angle in degrees)",
        "G10 L2 P2 X60 Y40 (the ring's centre is the origin of G55)",
        "G55",
        "G0 Z5",
    ]
    for _ in range(6):
        text += [
            "G0 X[#<radius> * COS[#1]] Y[#<radius> * SIN[#1]]",
            "G1 Z#<depth> F[60 + 20 * [#1 GT 90]]",
            "G4 P0.2",
            "G0 Z5",
            "#1 = [[#1 + 60] MOD 360]",
        ]
    text += ["G3 X[#<radius> + 5] Y0 R[[#<radius> * 2 + 5] / 2] F300", "G54", "G28", "M2", ""]
    return "\n".join(text)


PROGRAMS = {
    "engraving.ngc": lambda: engraving(SHORT),
    "arcs.ngc": arcs,
    "mixed_units.ngc": mixed_units,
    "expressions.ngc": expressions,
}


def main() -> None:
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(engraving(int(sys.argv[2])))
        return
    for name, make in PROGRAMS.items():
        (HERE / name).write_text(make())


if __name__ == "__main__":
    main()
