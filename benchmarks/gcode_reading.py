"""Time to read programs in G-code of 10,000 lines; at most 150 ms of CPU time are wanted for an engraving.

``gcode_engraving``: lines as CAM programs write them, X Y Z and now and then F. ``gcode_arcs``: an arc, a
line with expressions and a rapid in turns. The references are what is wanted: of the second that a program
may take until it is checked, a part for reading it.
"""

import statistics
import sys
import time
from pathlib import Path

from _report import check_work, is_quick, report

sys.path.insert(0, str(Path(__file__).parent.parent / "examples" / "gcode"))
from make_programs import engraving

from hil.gcode.reader import read_program

LINES = 10_000
RUNS = 3 if is_quick() else 15
WANTED_MS = {"gcode_engraving": 150.0, "gcode_arcs": 500.0}


def arcs() -> str:
    text = ["F600 #<deep>=-1"]
    for step in range(LINES // 3):
        text += [
            f"N{step} G2 X{step + 1:.3f} Y0 I0.5 J0 (arc {step})",
            f"G1 Z[#<deep> - {step % 9}/10] A{step % 90} F[100 + {step % 50}]",
            f"G0 X{step + 1} Y0 Z1",
        ]
    return "\n".join([*text, "M2", ""])


def main() -> None:
    for name, text in (("gcode_engraving", engraving(LINES)), ("gcode_arcs", arcs())):
        took_ms = []
        for _ in range(RUNS):
            began = time.process_time()
            program = read_program(text.encode())
            took_ms.append(1000 * (time.process_time() - began))
            assert not program.problems, program.problems[0]
            check_work("motions", len(program.motions), LINES, 0.001)
        extra = {"lines": text.count("\n"), "runs": RUNS, "reference": "what is wanted"}
        report(name, statistics.median(took_ms), "ms", WANTED_MS[name], 1.0, extra)


if __name__ == "__main__":
    main()
