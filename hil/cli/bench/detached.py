"""``hil serve --detach``: a bench in a process of its own that goes on when the command has ended."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from select import select
from typing import Any

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.host.paths import make_folder

LOG_NAME = "serve.log"
READY_S = 120.0
"""Maximum time in which the boards have to answer."""
_END_S = 10.0
_PIECE = 1 << 16
_MAIN = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"


def detach(words: list[str], state: Path) -> dict[str, Any]:
    """Start ``hil serve --json`` with these arguments; answers its report when the boards answer, with its
    log's path. ``state``: the bench's folder, in which the log lies.

    Raises:
        typer.Exit: it did not start, or not in time: then nothing is left of it.
    """
    try:
        make_folder(state)
        fd, begun = tempfile.mkstemp(prefix=f"{LOG_NAME}.", dir=state)  # that of a running bench stays
    except OSError as error:
        raise fail(f"hil: {error.filename or state}: {error.strerror}", Exit.MISTAKE) from None
    log = state / LOG_NAME
    command = [sys.executable, "-P", "-c", _MAIN, "serve", "--json", *words]
    with open(fd, "wb") as stream:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=stream,
            start_new_session=True,  # what ends a shell's jobs does not end it
        )
    try:
        assert process.stdout is not None
        with process.stdout as told, bar("the bench starts"):
            report = _report(process, told.fileno(), Path(begun))
        os.replace(begun, log)
    except BaseException:
        _end(process)
        with suppress(OSError):
            os.unlink(begun)
        raise
    return {**report, "log": str(log)}


def report_lines(report: dict[str, Any]) -> list[str]:
    """Lines of a report for a person."""
    lines = [f"bench {report['bench']} runs: process {report['pid']}"]
    lines += [f"  {name} at {address}" for name, address in report["ports"].items()]
    lines += [f"  {kind} at {', '.join(places)}" for kind, places in report["bridges"].items()]
    lines += [f"  {name} has stopped: {why}" for name, why in report["failed"].items()]
    return [*lines, f"Its log is {report['log']}. `hil shutdown` ends it."]


def _report(process: "subprocess.Popen[bytes]", told: int, log: Path) -> dict[str, Any]:
    """Report that it writes when the boards answer; ``told``: its output. Raises typer.Exit: it did not
    start."""
    line = b""
    while not line.endswith(b"\n") and select([told], [], [], READY_S)[0]:
        if not (piece := os.read(told, _PIECE)):
            process.wait()
            break
        line += piece
    if line.endswith(b"\n"):
        report: dict[str, Any] = json.loads(line)
        if error := report.get("error"):
            raise fail(error["message"], error["exit_code"])
        return report
    code, said = process.poll(), log.read_text(errors="replace").strip()
    why = f"the boards do not answer after {READY_S:g} s" if code is None else f"hil serve ended with {code}"
    raise fail(f"hil: {why}\n{said}".strip())


def _end(process: "subprocess.Popen[bytes]") -> None:
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        with suppress(subprocess.TimeoutExpired):
            process.wait(_END_S)
    if process.poll() is None:
        process.kill()
        process.wait()
