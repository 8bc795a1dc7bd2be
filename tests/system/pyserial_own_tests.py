"""pyserial's own tests, of its source package, at a port of a bench in virtual time and at a bare pty.

`python tests/system/pyserial_own_tests.py [FOLDER]` downloads the package, unless FOLDER has it unpacked, and
says which tests pass where; exit code 1 if one passes at the pty alone.
"""

import json
import os
import pty
import subprocess
import sys
import tarfile
import tempfile
import threading
from pathlib import Path

PACKAGE = "pyserial==3.5"
OWN_PORTS = ("test_pty",)
"""Modules that open ports of their own."""
LIMIT_S = 90.0
"""Maximum time for the tests of one module; those that are not over by then count as failed."""
BOARD = """
from hil.vocab.firmware import ByteAvailable
from hil.vocab.profile import Profile


class Echo:
    def __init__(self, board):
        self._uart = board.uart

    def main(self):
        while True:
            yield ByteAvailable()
            self._uart.write(self._uart.read_all())

    def interrupt(self, event):
        pass


PROFILE = Profile(firmware=Echo)
"""
BENCH = """
bench: echo
profile_path: [boards]
devices:
  e1: {profile: echo, port: pty}
  u1: {profile: echo, port: usb}
"""
RUNNER = """
import importlib, sys, unittest

folder, name, port = sys.argv[1:]
sys.path.insert(0, folder)
module = importlib.import_module(name)
module.PORT = port


class Told(unittest.TestResult):
    def addSuccess(self, test):
        sys.stderr.write(f"passed {test.id()}\\\\n")


unittest.defaultTestLoader.loadTestsFromModule(module).run(Told())
""".replace("\\\\n", "\\n")


def fetched(folder: Path) -> Path:
    """Download and unpack the package; answers the folder of its tests."""
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--no-binary", ":all:", PACKAGE]
    subprocess.run([*command, "-d", str(folder)], check=True)
    with tarfile.open(next(folder.glob("*.tar.gz"))) as package:
        package.extractall(folder, filter="data")
    return next(folder.glob("pyserial-*/test"))


def bench_in(folder: Path) -> Path:
    """Write the bench of the echo boards."""
    board = folder / "boards" / "echo"
    board.mkdir(parents=True)
    (board / "__init__.py").touch()
    (board / "board.py").write_text(BOARD)
    (board / "profile.yaml").write_text("# Echo.\nname: echo\ntitle: Echo\nuarts:\n  main: {}\n")
    (folder / "bench.yaml").write_text(BENCH)
    return folder / "bench.yaml"


def echo(master: int) -> None:
    """Send back what comes at a pty, until it is closed."""
    while True:
        try:
            os.write(master, os.read(master, 4096))
        except OSError:
            return


def passed(command: list[str], tests: Path, port: str) -> set[str]:
    """Run all tests, each module in a process of its own; answers the names of those that pass."""
    found = set[str]()
    for module in sorted(each for each in tests.glob("test*.py") if each.stem not in OWN_PORTS):
        options = [*command, str(tests), module.stem, port]
        process = subprocess.Popen(options, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        timer = threading.Timer(LIMIT_S, process.kill)
        timer.start()
        assert process.stderr
        found |= {line.split()[1] for line in process.stderr if line.startswith("passed ")}
        process.wait()
        timer.cancel()
    return found


def main() -> int:
    with tempfile.TemporaryDirectory(prefix="hil-pyserial-") as temporary:
        folder = Path(temporary)
        tests = Path(sys.argv[1]) if len(sys.argv) > 1 else fetched(folder)
        bench, runner = str(bench_in(folder)), folder / "runner.py"
        runner.write_text(RUNNER)
        master, slave = pty.openpty()
        threading.Thread(target=echo, args=(master,), daemon=True).start()
        at_pty = passed([sys.executable, str(runner)], tests, os.ttyname(slave))
        virtual = [str(Path(sys.executable).with_name("hil")), "virtual", bench, str(runner)]
        ours = {name: passed(virtual, tests, name) for name in ("e1", "u1")}
    missing = sorted(at_pty - ours["e1"])
    counts = {"a bare pty": len(at_pty)} | {f"b.serial of {name}": len(each) for name, each in ours.items()}
    more = sorted((ours["e1"] | ours["u1"]) - at_pty)
    print(json.dumps(counts | {"only at the pty": missing, "more": more}, indent=2))
    return bool(missing)


if __name__ == "__main__":
    sys.exit(main())
