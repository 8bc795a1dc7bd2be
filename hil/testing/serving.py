"""Processes of benches that are served: their starts and ends."""

import contextlib
import json
import os
import re
import select
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

from hil.testing.given import GivenConfig, as_json, path_of, unreadable
from hil.testing.live_desk import LiveError
from hil.testing.live_traffic import LiveCapture
from hil.testing.serial_ports.open_benches import LIVE
from hil.testing.served_bench import HIL, OPEN, READY_S, RECORDING, ServedBench, end_of

END_S = 60.0
"""Maximum time for a daemon to end in after SIGTERM."""
SHORT_PATH = 60
"""Maximum length of the folder for temporary files: the path of a socket has at most 107 bytes."""


@contextmanager
def live(
    config: GivenConfig,
    *,
    options: tuple[str, ...] = (),
    capture: bool = True,
    keep: Path | None = None,
    timeout_s: float = READY_S,
) -> Iterator[ServedBench]:
    """Run a bench in a process of its own for the block, which begins when its boards answer.

    ``config`` is a path, YAML text or a dict; files that a text or a dict names need absolute paths.
    ``options``: further ones of ``hil serve``, as ``("--log", "run.jsonl")``; ``capture``: record the traffic
    of all ports and lines; ``keep``: folder in which log, capture and recording stay.

    Raises:
        LiveError: the configuration has problems, which it lists, or the boards did not answer within
            ``timeout_s``.
        TypeError: ``config`` is no path, no text and no dict.
    """
    __tracebackhide__ = True
    with ExitStack() as stack:
        folder = Path(tempfile.mkdtemp(prefix="hil-", dir=_short_folder()))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        bench = stack.enter_context(_served(config, options, folder, keep or folder, timeout_s))
        if capture:
            bench.traffic = stack.enter_context(LiveCapture(bench.desk, bench.capture_file))
        stack.callback(bench.close)
        OPEN.append(bench)
        stack.callback(OPEN.remove, bench)
        LIVE.append((bench.info["bench"], bench.ports))
        stack.callback(LIVE.remove, LIVE[-1])
        stack.callback(bench.end_programs)
        try:
            yield bench
        except BaseException as error:
            error.add_note(f"--- the end of what hil serve said\n{end_of(bench.log)}")
            raise


@contextmanager
def _served(
    config: GivenConfig,
    options: tuple[str, ...],
    folder: Path,
    kept: Path,
    timeout_s: float,
) -> Iterator[ServedBench]:
    __tracebackhide__ = True
    path = _config_file(config, folder)
    where = ("--runtime-dir", str(folder / "run"), "--state-dir", str(folder / "state"))
    kept.mkdir(parents=True, exist_ok=True)
    has_own = any(option.split("=")[0] in ("--log", "--no-log") for option in options)
    recording = () if has_own else ("--log", str(kept.absolute() / RECORDING))
    command = [*HIL, "serve", str(path), "--json", *where, *recording, *options]
    with (kept / "hil.log").open("wb") as log:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log)
    bench = ServedBench(process, folder, kept)
    assert process.stdout is not None
    try:
        line, is_over = _line(process.stdout, timeout_s)
        if not line.endswith(b"\n"):
            _end(process)
            late = "" if is_over else f"the boards do not answer after {timeout_s:g} s\n"
            said = bench.log.strip() or f"hil serve ended with {process.returncode}"
            raise LiveError(late + _without_our_file(said, config, path))
        bench.info = json.loads(line)
        if error := bench.info.get("error"):
            raise LiveError(_without_our_file(error["message"], config, path))
        if failed := bench.info["failed"]:
            raise LiveError("\n".join(f"{name} has stopped: {why}" for name, why in failed.items()))
        yield bench
    finally:
        _end(process)


def _line(stream: IO[bytes], timeout_s: float) -> tuple[bytes, bool]:
    """Read a line, or what there is of it when the time is over or the stream ends; answers too whether it
    has ended."""
    line, until_s = b"", time.monotonic() + timeout_s
    while not line.endswith(b"\n") and (left_s := until_s - time.monotonic()) > 0:
        if select.select([stream], [], [], left_s)[0]:
            piece = os.read(stream.fileno(), 65536)
            if not piece:
                return line, True
            line += piece
    return line, False


def _end(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.terminate()
        process.wait(END_S)
    if process.poll() is None:
        process.kill()
        process.wait()
    if process.stdout:
        process.stdout.close()


def _config_file(config: GivenConfig, folder: Path) -> Path:
    __tracebackhide__ = True
    if given := path_of(config):
        try:
            given.stat()  # the daemon reads it, and says whatever else is wrong with it
        except (OSError, ValueError) as error:
            raise LiveError(str(unreadable(given, error))) from None
        return given
    path = folder / "bench.yaml"
    path.write_text(as_json(config) if isinstance(config, Mapping) else str(config))
    return path


def _without_our_file(said: str, config: GivenConfig, path: Path) -> str:
    """Name a configuration in a message as its writer knows it: a dict has no lines."""
    if isinstance(config, Mapping):
        return re.sub(re.escape(str(path)) + r"(:\d+:\d+)?", "<dict>", said)
    return said if path == path_of(config) else said.replace(str(path), "<text>")


def _short_folder() -> str:
    usual = tempfile.gettempdir()
    return usual if len(os.fsencode(usual)) <= SHORT_PATH else "/tmp"
