"""Output of a daemon in ``README.md`` and ``docs/tour.md``: one session, twenty times as fast."""

import re
import subprocess
import sys

from e2e_support import Place
from markdown_blocks import ROOT, block, fits

README, TOUR = "README.md", "docs/tour.md"
RT = r"rt: .*"
NUMBERS = r"-?\d[\d.,]*"
"""Times, counts and states of a bench that runs differ from one look to the next."""
HISTOGRAMS = r"(?:latency|lag) .*"
WEB = r"http://127\.0\.0\.1:\d+/"
"""Address of the page: another port where 8080 is taken."""
VERDICTS = r"(?:health|rt): (?s:.*?)(?=\n(?:rt|wakes))"
"""Verdicts on this machine, which differ elsewhere; long lines are broken."""

VARYING = r"(?m:^recording +\S+$)", WEB, VERDICTS, HISTOGRAMS, r" +", NUMBERS


def shown(page: str, heading: str, place: Place, index: int = 0) -> str:
    """A block with this place's folder instead of the reader's, and without the lines that are typed."""
    text = block(page, heading, index).replace("/run/user/1000/hil", str(place.runtime))
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith("$ "))


def test_the_tour(place: Place) -> None:
    log = place.folder / "run.jsonl"
    demo = (ROOT / "examples" / "demo.yaml").read_text()
    server = place.serve(f"{demo}\nspeed: 20\n", "--log", str(log), bench="demo")
    machine = r"(?m:^  \S+python\S*)", r"(?m:^  \S*hil)(?= monitor )"
    said = server.output.replace(f" --runtime-dir {place.runtime}", "")
    for page, heading in ((README, "Start"), (TOUR, "Tour")):  # fits what was printed before and after, too
        assert fits(f"...\n{shown(page, heading, place)}...", said, RT, WEB, *machine), said

    server.ready()
    program, printed = (block(TOUR, "Use it from a program", index) for index in range(2))
    program = program.replace("/run/user/1000/hil", str(place.runtime))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert fits(printed, done.stdout), done

    said = place.cli("status", "--bench", "demo")
    assert fits(shown(TOUR, "Look at the bench", place), said, *VARYING), said

    lines = re.findall(r"^\$ hil (.*)$", block(TOUR, "Make it fail"), re.M)
    said = "".join(place.cli(*line.split(), "--runtime-dir", str(place.runtime)) for line in lines)
    assert fits(shown(TOUR, "Make it fail", place), said)

    server.stop()
    said = place.hil("replay", str(log))
    shown_last = shown(TOUR, "Record a run and run it again", place).splitlines()[-1]
    assert fits(shown_last, said, NUMBERS)
