"""``examples/modbus``: its program prints what stands beside it."""

import re
import subprocess
import sys
from pathlib import Path

from e2e_support import PATIENCE_S, Place, free_port

FOLDER = Path(__file__).parents[1] / "examples" / "modbus"


def test_the_poll_of_sixteen_axes_prints_what_stands_beside_it() -> None:
    program, number = FOLDER / "poll16.py", free_port()
    assert len(program.read_text().splitlines()) < 40
    text = program.with_suffix(".yaml").read_text()
    with Place() as place:
        place.serve(text.replace("modbus: {}", f"modbus: {{listen: 127.0.0.1:{number}}}"), bench="poll16")
        command = [sys.executable, str(program), str(number)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.stderr == ""
    assert rounded(done.stdout) == rounded(program.with_suffix(".txt").read_text())


def rounded(table: str) -> list[str]:
    """Lines with angles to 0.1 deg: on a busy computer a shaft that has just arrived still settles."""
    return [re.sub(r"\d+\.\d+", lambda found: f"{float(found[0]):.1f}", line) for line in table.splitlines()]
