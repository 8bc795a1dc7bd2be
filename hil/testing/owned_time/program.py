"""Runs a program on the simulated time of a bench: the main module of its process."""

import _thread
import argparse
import json
import os
import signal
import sys
import threading
import types
from collections.abc import Mapping
from importlib.machinery import SourceFileLoader
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hil.config import ConfigError
from hil.testing.bench import Bench
from hil.testing.owned_time.children import Children
from hil.testing.owned_time.clocks import FIRST_DATE_S, Clocks
from hil.testing.owned_time.listed_ports import lister
from hil.testing.owned_time.lockstep import Lockstep
from hil.testing.owned_time.put_in_place import put_in_place
from hil.testing.owned_time.thread_turn import is_hils
from hil.testing.owned_time.turns import Turns
from hil.vocab.time import NS_PER_MS

MISTAKE = 2
"""Exit code for what is wrong before the program begins."""


def main() -> None:
    """Read the options that ``hil virtual`` has checked, and run."""
    parser = argparse.ArgumentParser(prog="hil virtual", add_help=False)
    parser.add_argument("bench")
    parser.add_argument("--map", action="append", default=[])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--date", type=float, default=FIRST_DATE_S)
    parser.add_argument("--module", action="store_true")
    parser.add_argument("--beside", type=int)
    parser.add_argument("program")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    given = parser.parse_args()
    if given.module and not _has_module(given.program):
        _say(f"there is no module {given.program!r}; write one that python -m finds from {os.getcwd()}")
        sys.exit(MISTAKE)
    mapped = dict(each.rpartition("=")[::2] for each in given.map)
    try:
        bench, beside = _bench(given)
        _place(bench, mapped, given.date, beside)
    except ConfigError as error:
        _say(f"the bench cannot be used; what to do stands in brackets\n{error}")
        sys.exit(MISTAKE)
    except (KeyError, ValueError) as error:
        _say(str(error))
        sys.exit(MISTAKE)
    code = _run(given.program, given.arguments, given.module)
    if beside:
        threading._shutdown()  # type: ignore[attr-defined]
        beside.ended(code)
    if code == -signal.SIGINT:
        sys.excepthook = lambda *_: None  # told already
        raise KeyboardInterrupt  # with which Python ends itself by the signal
    sys.exit(code)


def _bench(given: argparse.Namespace) -> tuple[Bench, Lockstep | None]:
    """Bench of a file, or a second one beside a test's, which says over a socket what it is."""
    if given.beside is None:
        bench = Bench(given.bench, given.seed)
        if late := bench.start():
            _say(f"{', '.join(late)} did not answer; the program starts all the same")
        return bench, None
    # Files, not sockets: those of the program wait in simulated time.
    from_test, to_test = os.fdopen(given.beside), os.fdopen(os.dup(given.beside), "w")
    first = json.loads(from_test.readline())
    window_ms = first["arrival_window_ms"]
    # Its faults are inputs, too: they come from the test.
    bench = Bench(first["config"], first["seed"], arrival_window_ms=window_ms, leaves_out=lambda key: True)
    bench.play(first["inputs"])
    bench.run_until(first["now_ns"] / NS_PER_MS)
    return bench, Lockstep(from_test, to_test, bench)


def _has_module(name: str) -> bool:
    """True if Python finds a module, or the package that it is in: to find out more would run it."""
    sys.path.insert(0, os.getcwd())
    try:
        return find_spec(name.partition(".")[0]) is not None
    except ValueError:  # of an empty name, as of no module
        return False
    finally:
        del sys.path[0]


def _say(text: str) -> None:
    sys.stderr.write(f"hil: {text}\n")


def _place(bench: Bench, mapped: Mapping[str, str], date_s: float, beside: Lockstep | None) -> None:
    """Let this process live on the bench's time. ``mapped``: names of ports by paths of the program."""
    ports = bench.serial_ports
    turns = Turns(bench.runtime, [*ports.terminals.values()], bench.arrivals, _say)
    terminals = ports.named(mapped)
    children, port_class = Children(turns, terminals), ports.class_for(turns, terminals, has_map=True)
    ports.serial_class = port_class  # of ``hil://`` too
    start_real = _thread.start_new_thread
    put_in_place(
        turns, Clocks(turns, date_s), children, port_class, ports.descriptors, lister(ports.bench, terminals)
    )
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    start_real(turns.watch, ())  # which gets none of the program's signals
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    if beside:
        beside.waits, turns.synchronize = turns.who_waits, beside.synchronize
        turns.stop_ns = beside.synchronize()


def _run(program: str, arguments: list[str], is_module: bool) -> int:
    sys.argv = [program, *arguments]
    try:
        _execute(program, is_module)
    except SystemExit as error:
        if isinstance(error.code, str):
            sys.stderr.write(f"{error.code}\n")
        return error.code if isinstance(error.code, int) else int(error.code is not None)
    except (Exception, KeyboardInterrupt) as error:
        of_program = _without_hil(error.__traceback__)
        sys.excepthook(type(error), error.with_traceback(of_program), of_program)
        return -signal.SIGINT if isinstance(error, KeyboardInterrupt) else 1
    return 0


def _without_hil(traceback: types.TracebackType | None) -> types.TracebackType | None:
    """Frames of a traceback that are not hil's."""
    if traceback is None:
        return None
    rest = _without_hil(traceback.tb_next)
    if is_hils(traceback.tb_frame.f_code.co_filename):
        return rest
    return types.TracebackType(rest, traceback.tb_frame, traceback.tb_lasti, traceback.tb_lineno)


def _execute(program: str, is_module: bool) -> None:
    if is_module:
        import runpy  # noqa: TID251 - the program's module

        sys.path[0] = os.getcwd()
        runpy.run_module(program, run_name="__main__", alter_sys=True)
        return
    path = Path(program)
    sys.path[0] = str(path.resolve().parent)
    module = types.ModuleType("__main__")
    names: dict[str, Any] = vars(module)
    loader = SourceFileLoader("__main__", program)
    names |= {"__file__": program, "__builtins__": __builtins__, "__loader__": loader, "__cached__": None}
    sys.modules["__main__"] = module  # noqa: TID251 - as Python does for a program
    exec(compile(path.read_bytes(), program, "exec"), names)


if __name__ == "__main__":
    main()
