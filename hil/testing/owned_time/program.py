"""Runs a program on the simulated time of a bench: the main module of its process."""

import argparse
import sys
import threading
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hil.config import ConfigError
from hil.testing.bench import Bench
from hil.testing.owned_time.children import Children
from hil.testing.owned_time.clocks import FIRST_DATE_S, Clocks
from hil.testing.owned_time.put_in_place import put_in_place
from hil.testing.owned_time.turns import Turns

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
    parser.add_argument("program")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    given = parser.parse_args()
    mapped = dict(each.rpartition("=")[::2] for each in given.map)
    try:
        bench = Bench(given.bench, given.seed)
        _place(bench, mapped, given.date)
    except (ConfigError, KeyError, ValueError) as error:
        _say(str(error))
        sys.exit(MISTAKE)
    sys.exit(_run(given.program, given.arguments, given.module))


def _say(text: str) -> None:
    sys.stderr.write(f"hil virtual: {text}\n")


def _place(bench: Bench, mapped: Mapping[str, str], date_s: float) -> None:
    """Let this process live on the bench's time. ``mapped``: names of ports by paths of the program."""
    if late := bench.start():
        _say(f"{', '.join(late)} did not answer; the program starts all the same")
    ports = bench.serial_ports
    turns = Turns(bench.runtime, [*ports.terminals.values()], _say)
    terminals = ports.named(mapped)
    children, port_class = Children(turns, terminals), ports.class_for(turns, terminals)
    ports.serial_class = port_class  # of ``hil://`` too
    start_real = threading._start_new_thread  # type: ignore[attr-defined]
    put_in_place(turns, Clocks(turns, date_s), children, port_class, ports.descriptors)
    start_real(turns.watch, ())


def _run(program: str, arguments: list[str], is_module: bool) -> int:
    sys.argv = [program, *arguments]
    if is_module:
        import runpy  # noqa: TID251 - the program's module

        sys.path[0] = ""
        runpy.run_module(program, run_name="__main__", alter_sys=True)
        return 0
    path = Path(program)
    sys.path[0] = str(path.resolve().parent)
    module = types.ModuleType("__main__")
    names: dict[str, Any] = vars(module)
    names |= {"__file__": program, "__builtins__": __builtins__}
    sys.modules["__main__"] = module  # noqa: TID251 - as Python does for a program
    code = compile(path.read_bytes(), program, "exec")
    try:
        exec(code, names)
    except Exception as error:
        of_program = error.__traceback__ and error.__traceback__.tb_next
        sys.excepthook(type(error), error.with_traceback(of_program), of_program)
        return 1
    return 0


if __name__ == "__main__":
    main()
