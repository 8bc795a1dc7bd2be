"""A run that mixes twins and a real board behind a serial port, in real time, 10 seconds.

The board is scripted, so that this runs anywhere. With one of your own: write its port to `at:` in
mixed.yaml, then `hil serve mixed.yaml`, `hil axis m1 enable`, `hil axis m2 enable`, `hil run mixed.run.yaml`.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from scripted_board import ScriptedBoard

HERE = Path(__file__).parent
HIL = Path(sys.executable).with_name("hil")
PATIENCE_S = 30


def hil(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [str(HIL), *arguments, "--runtime-dir", str(folder / "run")]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def until_it_works(folder: Path, *arguments: str) -> None:
    """Run a command until it works: boards take some seconds to start."""
    deadline = time.monotonic() + PATIENCE_S
    while (done := hil(folder, *arguments)).returncode:
        if time.monotonic() > deadline:
            raise SystemExit(done.stderr)
        time.sleep(0.2)


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        port, bench = folder / "scripted-board", folder / "mixed.yaml"
        board = ScriptedBoard(port)
        bench.write_text((HERE / "mixed.yaml").read_text().replace("/dev/ttyACM0", str(port)))
        places = ("--runtime-dir", str(folder / "run"), "--state-dir", str(folder / "state"))
        serving = subprocess.Popen([HIL, "serve", bench, *places], stdout=subprocess.DEVNULL)
        try:
            for axis in ("m1", "m2"):
                until_it_works(folder, "axis", axis, "enable")
            print(hil(folder, "run", str(HERE / "mixed.run.yaml")).stdout, end="")
        finally:
            serving.terminate()
            serving.wait(PATIENCE_S)
            board.close()
    print(f"the last that the board was told is {board.told[-1]:.3f} deg")


if __name__ == "__main__":
    main()
