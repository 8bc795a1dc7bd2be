"""The reference of G-code: every word, function and operator, and where LinuxCNC differs, as Markdown."""

from collections.abc import Iterable

from hil.gcode.differences import DIFFERENCES
from hil.gcode.expressions import EQUAL, FUNCTIONS, LAST_PARAMETER
from hil.gcode.program_text import LONGEST
from hil.gcode.words import G_WORDS, LETTERS, M_WORDS, REFUSED_LETTERS

_ABOUT = f"""\
RS-274/NGC (NISTIR 6556) without subroutines, in the words of LinuxCNC 2.9. A line has at most {LONGEST}
characters. Blanks, and capital or small letters, make no difference. A comment stands in `( )`, or from `;`
to the end; `(MSG, text)` is shown. A `/` at the beginning lets a line be left out. A program ends with M2
or M30, or has `%` alone in its first line and in its last.

What the words of a line do is done in this order, whatever their order in the line:

1. parameters; G93 to G95; F, S, T
2. M6; M3 to M5; M7 to M9; G4
3. G17 to G19; G20 and G21; G54 to G59.3; G61 to G64; G90 to G91.1
4. G10, G28, G30, G53 and G92; the motion
5. M0 to M2 and M30

Of each group a line has one word, and at most four M words. A program begins with G17, G21, G90, G91.1,
G94, G54, and without motion mode and feed.
"""
_VALUES = f"""\
A value is a number (`1`, `-.5`, `+2.`; no exponent), a parameter, a function, or an expression in `[ ]`.
Operators, the strongest first: `**`; `*`, `/`, `MOD` (never below 0); `+`, `-`; `EQ`, `NE`, `GT`, `GE`,
`LT`, `LE`, which are 1 or 0, and for which values nearer than {EQUAL:g} are equal; `AND`, `OR`, `XOR`.
Operators of equal strength are applied from left to right.

Parameters are `#1` to `#{LAST_PARAMETER}`, 0 if nothing has set them, and names: `#<depth> = 2`. A new
value holds after the line that sets it. In millimetres and degrees, `#5161` to `#5169` are the place of
G28, `#5181` to `#5189` that of G30, and `#5211` to `#5219` the offsets of G92. `#5220` is the coordinate
system, `#5221` to `#5229` are the first one's origin, and so on in steps of 20. `#5420` to `#5428` and
`#<_x>` to `#<_w>` are where the axes are, in the units of the program. Read only are also `#<_metric>`,
`#<_imperial>`, `#<_absolute>`, `#<_incremental>`, `#<_inverse_time>`, `#<_units_per_minute>`,
`#<_units_per_rev>`, `#<_feed>` and `#<_rpm>`.
"""
_USES = {"done": "", "accepted": "nothing to do", "refused": "refused"}


def gcode_reference() -> str:
    """Write the part of the reference about programs in G-code."""
    words = sorted(
        (*G_WORDS.values(), *M_WORDS.values()), key=lambda word: (word.name[0], float(word.name[1:]))
    )
    done = ((word.name, word.group, word.meaning, _USES[word.use]) for word in words if word.use != "refused")
    refused = ((word.name, word.meaning, word.remedy) for word in words if word.use == "refused")
    letters = (
        *LETTERS.items(),
        *((letter.upper(), f"refused: {why}") for letter, why in REFUSED_LETTERS.items()),
    )
    differences = ((row.what, f"{row.ours} / {row.theirs}", row.why) for row in DIFFERENCES)
    return (
        "\n\n".join(
            [
                "## G-code",
                _ABOUT.strip(),
                _table(("word", "group", "meaning", ""), done),
                _table(("word that is refused", "meaning", "what to do"), refused),
                _table(("letter", "number behind it"), letters),
                "### Values and parameters",
                _VALUES.strip(),
                _table(("function", "value"), ((f"`{name}`", about) for name, about in FUNCTIONS.items())),
                "### Where LinuxCNC differs",
                _table(("what", "here / LinuxCNC 2.9", "why"), differences),
            ]
        )
        + "\n"
    )


def _table(heads: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [heads, ("---",) * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in lines)
