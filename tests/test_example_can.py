"""``examples/can``: its program prints what stands beside it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place

PATIENT = Path(__file__).with_name("patient_master.py")
FOLDER = Path(__file__).parents[1] / "examples" / "can"


@pytest.mark.thorough
def test_four_axes_stand_where_the_program_says(tmp_path: Path) -> None:
    """How far they are apart varies by the noise of their loops."""
    program = FOLDER / "four_axes.py"
    source = program.read_text()
    assert len(source.splitlines()) < 40
    patient = tmp_path / program.name  # a computer that runs all tests at once is not there each 100 ms
    patient.write_text(source.replace("= 100, -3", "= 250, -3").replace("sleep(0.1)", "sleep(0.25)"))
    with Place() as place:
        place.serve((FOLDER / "bench.yaml").read_text(), bench="four").ready()
        eds = tmp_path / "drive.eds"
        eds.write_text(place.hil("can", "eds", "m1", "--runtime-dir", str(place.runtime)))
        command = [
            sys.executable,
            str(PATIENT),
            str(patient),
            str(place.runtime / "four" / "can0.slcan0"),
            str(eds),
        ]
        done = subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S, check=False)
    assert done.stderr == ""
    said, wanted = (text.splitlines() for text in (done.stdout, program.with_suffix(".txt").read_text()))
    angles, shown = ([float(each) for each in line[0].split()[3:]] for line in (said, wanted))
    assert all(abs(angle - at) <= 0.1 for angle, at in zip(angles, shown, strict=True))
    apart_deg = re.fullmatch(r"36 SYNCs, never more than (\d\.\d\d) deg apart", said[1])
    assert apart_deg, said
    assert float(apart_deg[1]) < 0.2
