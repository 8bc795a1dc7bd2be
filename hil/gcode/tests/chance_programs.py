"""Programs by chance, and damage to programs: the same ones for the same seed."""

from random import Random

_FUNCTIONS = ("ABS", "ACOS", "ASIN", "COS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN")
_SAFE = ("ABS", "COS", "FIX", "FUP", "ROUND", "SIN")
_OPERATORS = ("*", "+", "-", "EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "XOR")
_MODES = (
    *("G17", "G18", "G19", "G20", "G21", "G40", "G49", "G54", "G55", "G56", "G59", "G59.1", "G59.3", "G61"),
    *("G61.1", "G64", "G80", "G90", "G91", "G90.1", "G91.1", "G94", "G98", "G99", "G8", "G97"),
    *("M5", "M9", "M48", "M49", "M0", "M1"),
)
_RARE = (
    *(
        "G28",
        "G28.1",
        "G30",
        "G30.1",
        "M6",
        "G93",
        "G95 M4 F1",
        "G12",
        "M17",
        "O5",
        "G53",
    ),
    *(
        "G4",
        "G92",
        "G10",
        "G2",
        "G3",
        "G1 G0",
        "G20 G21",
        "M3 M5",
        "X",
        "Y1 Y2",
        "F-1",
        "S-1",
        "P1",
        "I2",
        "R3",
    ),
    *(
        "L2",
        "Q1",
        "D1",
        "E1",
        "H1",
        "G0 X[1",
        "#7",
        "#0=1",
        "#5420=1",
        "X#<no>",
        "(a",
        "(a(b)",
        "X1)",
        "N",
        "G",
    ),
    *("%", "X1.2.3", "X[1/0]", "X SQRT[-1]", "G54.1", "T1.5", "M3.2", "G17 G18", "X1,2"),
    *("#<a>", "G61 G64", "G0 X1 I2", "X[3 MOD 0]", "G91 G53 G0", "A1 B2 C3"),
)
MOST = 250
"""Characters of a line: LinuxCNC takes 253."""

_DAMAGE = b"GMXYZIJKRFSPLNO#[]()<>;/%=+-*.0123456789 \n\r\t\0\xff\xc3gmxyz"


def number(chance: Random, most: float = 100.0) -> str:
    """A number in one of the forms of the language."""
    value = chance.uniform(-most, most)
    text = f"{value:.{chance.choice((0, 1, 3, 4))}f}"
    form = chance.random()
    if form < 0.1:
        text = text.replace("0.", ".") if "0." in text else text + ("" if "." in text else ".")
    elif form < 0.15:
        text = f"+{text}" if value >= 0 else text
    return text


def expression(chance: Random, depth: int = 0) -> str:
    """An expression in brackets. Its value may be none."""
    if depth > 1 or chance.random() < 0.3:
        return chance.choice((number(chance, 9), f"#{chance.randint(1, 9)}", "#<a>", "#<_two>"))
    if chance.random() < 0.25:
        inside = expression(chance, depth + 1)
        inside = inside if inside.startswith("[") else f"[{inside}]"
        if chance.random() < 0.2:
            return f"ATAN{inside}/[{number(chance, 9)}]"
        return f"{chance.choice(_FUNCTIONS if chance.random() < 0.05 else _SAFE)}{inside}"
    operands = [expression(chance, depth + 1) for _ in range(chance.randint(2, 3))]
    words = [operands[0]]
    for operand in operands[1:]:
        if chance.random() < 0.1:
            words += chance.choice(
                (("**", "2"), ("/", f"[ABS[{operand}]+1]"), ("MOD", f"[ABS[{operand}]+1]"))
            )
        else:
            words += chance.choice(_OPERATORS), operand
    return f"[{' '.join(words)}]"


def value(chance: Random, most: float = 100.0) -> str:
    return expression(chance) if chance.random() < 0.05 else number(chance, most)


def axes(chance: Random, letters: str = "XYZABC") -> str:
    chosen = [letter for letter in letters if chance.random() < 0.4] or [chance.choice(letters)]
    if chance.random() < 0.3:
        chance.shuffle(chosen)
    return " ".join(f"{letter}{value(chance)}" for letter in chosen)


_ARCS = {
    "G17": ("X", "#5420", "I", "Y", "#5421", "J", "Z"),
    "G18": ("Z", "#5422", "K", "X", "#5420", "I", "Y"),
    "G19": ("Y", "#5421", "J", "Z", "#5422", "K", "X"),
}
"""Of each plane the words of its first and second axis: end, where it is, centre; and the axis across."""


def arc(chance: Random) -> str:
    """An arc that fits, from wherever the axes are: its end is told by where they are."""
    plane = chance.choice((*_ARCS,))
    x, here, i, y, there, j, across = _ARCS[plane]
    dx, dy = chance.uniform(-20, 20), chance.uniform(-20, 20)
    helix = f" {across}{number(chance)}" if chance.random() < 0.3 else ""
    turns = f" P{chance.randint(1, 3)}" if chance.random() < 0.3 else ""
    centre, modes = f"{i}{dx / 2:.5f} {j}{dy / 2:.5f}", "G90 G91.1"
    match chance.randint(0, 5):
        case 0:
            words = f"{x}[{here}+{dx:.3f}] {y}[{there}+{dy:.3f}] {centre}{turns}"
        case 1:
            radius = chance.choice((-1, 1)) * chance.uniform(15, 50)
            words = f"{x}[{here}+{dx:.3f}] {y}[{there}+{dy:.3f}] R{radius:.3f}{turns}"
        case 2:
            words = f"{i}{dx:.3f} {j}{dy:.3f}{turns}"
        case 3:
            words, modes = f"{x}{dx:.3f} {y}{dy:.3f} {centre}", "G91 G91.1"
        case 4:
            words = f"{x}[{here}+{dx:.3f}] {y}[{there}+{dy:.3f}]"
            words += f" {i}[{here}+{dx / 2:.5f}] {j}[{there}+{dy / 2:.5f}]"
            modes = "G90 G90.1"
        case _:
            words = f"{x}[{here}+{2 * dx:.3f}] {i}{dx + chance.uniform(-1e-3, 1e-3):.5f}"
    rotary = f" A{number(chance)}" if chance.random() < 0.1 else ""
    feed = f"F{chance.randint(1, 900)}"
    return f"{modes} {plane} {chance.choice(('G2', 'G3'))} {words}{helix}{rotary} {feed}"


def line(chance: Random, rare: float) -> str:
    """A line; ``rare`` is the share of those that most programs do not have."""
    if chance.random() < rare:
        words = [chance.choice(_RARE) for _ in range(chance.randint(1, 2))]
        return " ".join(words + ([axes(chance)] if chance.random() < 0.4 else []))
    match chance.randint(0, 13):
        case 0 | 1:
            return f"G0 {axes(chance)}"
        case 2 | 3 | 4:
            return f"G1 {axes(chance, 'XYZ')} F{chance.randint(1, 2000)}"
        case 5:
            return axes(chance)
        case 6 | 7:
            return arc(chance)
        case 8:
            return " ".join(chance.sample(_MODES, chance.randint(1, 2)))
        case 9:
            return f"#{chance.choice((str(chance.randint(1, 9)), '<a>', '<_two>'))}={value(chance)}"
        case 10:
            return chance.choice(
                (
                    f"S{chance.randint(0, 9000)} M{chance.randint(3, 5)}",
                    "M7",
                    "M8",
                    f"T{chance.randint(0, 2)}",
                )
            )
        case 11:
            return chance.choice(
                (
                    f"G10 L{chance.choice((2, 20))} P{chance.randint(0, 9)} {axes(chance)}",
                    f"G92 {axes(chance)}",
                    f"G53 G0 {axes(chance)}",
                    f"G28 {axes(chance)}",
                )
            )
        case 12:
            words = (
                f"G4 P{chance.randint(0, 9)}.5",
                f"G64 P0.{chance.randint(0, 99)}",
                "G92.1",
                "G92.2",
                "G92.3",
            )
            return chance.choice(words)
        case _:
            moved = arc(chance) if chance.random() < 0.3 else f"G1 X{number(chance)} F{chance.randint(1, 50)}"
            return f"G93 {moved}\nG94 F{chance.randint(1, 900)}"


def written(chance: Random, text: str) -> str:
    """The same line in other letters, with blanks, a number or a comment."""
    if chance.random() < 0.2:
        text = text.lower()
    if chance.random() < 0.1:
        text = text.replace(" ", "")
    if chance.random() < 0.1:
        text = f"N{chance.randint(0, 9999)} {text}"
    if chance.random() < 0.1:
        text += chance.choice((" (c)", ";c", " ( a ) ; b"))
    return text


def program(seed: int, rare: float = 0.02) -> str:
    """A program of up to forty lines."""
    chance = Random(seed)
    lines = ["F500 S1000 G0 X0", "#<a>=2 #<_two>=3"]
    lines += [written(chance, line(chance, rare))[:MOST] for _ in range(chance.randint(1, 40))]
    return "\n".join([*lines, "M2", ""])


def damaged(chance: Random, text: bytes) -> bytes:
    """A text in which bytes are changed, lost, added, doubled or cut off."""
    data = bytearray(text)
    for _ in range(chance.randint(1, 4)):
        at = chance.randrange(len(data) + 1)
        match chance.randint(0, 5):
            case 0:
                data[at : at + 1] = bytes([chance.choice(_DAMAGE)])
            case 1:
                del data[at : at + chance.randint(1, 5)]
            case 2:
                data[at:at] = bytes(chance.choice(_DAMAGE) for _ in range(chance.randint(1, 4)))
            case 3:
                data[at:at] = data[at : at + chance.randint(1, 30)] * chance.randint(1, 3)
            case 4 if chance.random() < 0.2:
                del data[at:]
            case _:
                data[at : at + 1] = bytes([chance.randrange(256)])
    return bytes(data)
