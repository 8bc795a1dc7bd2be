"""Trace of a compiled sketch on the processor alone: ``python -m hil.testing.sketch_trace DIR -o TRACE``.

A folder DIR has what is given and asked for, as data of three columns ``cycle,what,value`` and as JSON:

- ``inputs.csv``: a pin (D0 to D13, A0 to A5) that gets a level, -1: nothing drives it; ``RX``, a byte whose
  start bit begins then, at 115200 baud; ``V0`` to ``V7``, volts at A0 to A7.
- ``expect.json``: ``cycles``, how long it runs from the first instruction on.

The trace has what comes out: edges of pins that the chip drives (one that it does not drive counts as 0; D1
is not in it while frames go over it), ``TX``, a byte at the first cycle of its frame, ``RESET`` with the
bit of MCUSR. The flash comes from ``--hex``, else from the one ``.hex`` in DIR, else from
``DIR/../build/NAME.hex`` or ``DIR/build/NAME.hex``. Standard output tells how many times real time it ran.
"""

import argparse
import csv
import json
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from hil.core._processor import WITHOUT_FRAMES, Event, Processor
from hil.host.new_file import write_file
from hil.sketch.chip_program import read_program
from hil.sketch.program_error import ProgramError

CLOCK_HZ = 16_000_000
RX_BIT_CYCLES = CLOCK_HZ / 115_200
POWER_ON = 1
DIGITAL, ANALOGUE = 14, 6
"""Number of pins of an Uno that are called D, and A; A0 to A5 are its pins 14 to 19."""
PINS = {f"D{n}": n for n in range(DIGITAL)} | {f"A{n}": DIGITAL + n for n in range(ANALOGUE)}
NAMES = {number: name for name, number in PINS.items()}
VOLTS = {f"V{n}": n for n in range(8)}
HIGH = 1
BAD_INPUT = 2
"""Exit code where something that was given cannot be used."""


class BadInput(Exception):
    """Fault of what was given, as a sentence."""


class Input(NamedTuple):
    """Level, byte or voltage that comes from outside at a cycle."""

    cycle: int
    what: str
    value: float


def read_inputs(path: Path) -> list[Input]:
    """Read ``inputs.csv``, in the order of its cycles.

    Raises:
        BadInput: it is not there, or a line is none.
    """
    try:
        rows = list(csv.reader(path.read_text().splitlines()))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path} cannot be read: {error}") from None
    inputs = [_input(path, number, row) for number, row in enumerate(rows, 1) if row]
    return sorted(inputs, key=lambda each: each.cycle)


def _input(path: Path, number: int, row: list[str]) -> Input:
    try:
        cycle, what, value = row
        made = Input(int(cycle), what, float(value))
    except ValueError:
        raise BadInput(f"{path}:{number}: no line of cycle,what,value: {','.join(row)}") from None
    if made.cycle < 0 or not (what in PINS or what in VOLTS or what == "RX"):
        raise BadInput(f"{path}:{number}: no pin, RX or V0 to V7 from cycle 0 on: {','.join(row)}")
    return made


def read_cycles(path: Path) -> int:
    """Read how long a sketch runs from ``expect.json``.

    Raises:
        BadInput: it is not there, or does not say so.
    """
    try:
        cycles = json.loads(path.read_text())["cycles"]
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error}") from None
    except (ValueError, KeyError, TypeError):
        cycles = None
    if not isinstance(cycles, int) or cycles <= 0:
        raise BadInput(f'{path} does not say how long it runs: "cycles" has to be a whole number above 0')
    return cycles


def find_hex(folder: Path) -> Path:
    """Find the compiled sketch of a folder.

    Raises:
        BadInput: there is none, or more than one.
    """
    name = folder.resolve().name
    beside = sorted(folder.glob("*.hex"))
    if len(beside) > 1:
        raise BadInput(f"{folder} has {len(beside)} files .hex: name one with --hex")
    built = [folder.resolve().parent / "build" / f"{name}.hex", folder / "build" / f"{name}.hex"]
    if not (found := [*beside, *(path for path in built if path.is_file())]):
        raise BadInput(f"{folder} has no .hex, and {built[0]} is not there: build it, or name one with --hex")
    return found[0]


def read_flash(path: Path) -> tuple[bytes, bytes]:
    """Read what a compiled sketch has for flash and EEPROM.

    Raises:
        BadInput: the file is not there, damaged, or for another chip.
    """
    try:
        program = read_program(str(path), path.read_bytes())
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error}") from None
    except ProgramError as error:
        raise BadInput(str(error)) from None
    return program.flash, program.eeprom or b""


def run_trace(chip: Processor, inputs: Iterable[Input], cycles: int, stop_cycles: int = 0) -> list[Event]:
    """Run a processor that was reset, with its inputs; ``stop_cycles``: it stops each so many, 0: at inputs
    alone."""
    events: list[Event] = []
    for each in inputs:
        if each.cycle > cycles:
            break
        events += _run_on(chip, each.cycle, stop_cycles)
        _put_in(chip, each)
    return events + _run_on(chip, cycles, stop_cycles)


def _run_on(chip: Processor, until: int, stop_cycles: int) -> list[Event]:
    events: list[Event] = []
    if stop_cycles:
        for stop in range(chip.cycles + stop_cycles, until, stop_cycles):
            events += chip.run(stop)
    return events + chip.run(until)


def _put_in(chip: Processor, given: Input) -> None:
    if given.what == "RX":
        if not chip.hear(given.cycle, int(given.value), RX_BIT_CYCLES):
            raise BadInput(f"cycle {given.cycle}: too many bytes are on their way at once")
    elif given.what in VOLTS:
        chip.volts(VOLTS[given.what], given.value)
    else:
        chip.pin(PINS[given.what], int(given.value))


def trace_lines(events: Iterable[Event]) -> Iterator[str]:
    """Make the lines of a trace."""
    levels = dict.fromkeys(NAMES, 0)
    for cycle, kind, one, other in events:
        if kind == "sent":
            yield f"{cycle},TX,{one & 0xFF}"
        elif kind == "reset":
            yield f"{cycle},RESET,{one}"
        elif kind == "pin" and levels[one] != (level := int(other == HIGH)):
            levels[one] = level
            yield f"{cycle},{NAMES[one]},{level}"


def make_trace(options: argparse.Namespace) -> None:
    """Run a folder's sketch, write its trace and tell how fast it was.

    Raises:
        BadInput: something that was given cannot be used.
    """
    folder: Path = options.folder
    cycles, inputs = read_cycles(folder / "expect.json"), read_inputs(folder / "inputs.csv")
    flash, eeprom = read_flash(options.hex or find_hex(folder))
    chip = Processor()
    chip.load(flash)
    chip.load_eeprom(eeprom)
    chip.watch((1 << len(PINS)) - 1 | WITHOUT_FRAMES)
    chip.reset(POWER_ON)
    begun = time.process_time()
    events = run_trace(chip, inputs, cycles, options.stops)
    spent_s = time.process_time() - begun
    try:
        write_file(options.output, "".join(f"{line}\n" for line in trace_lines(events)).encode())
    except OSError as error:
        raise BadInput(f"{options.output} cannot be written: {error}") from None
    real_s = cycles / CLOCK_HZ
    times = real_s / max(spent_s, 1e-6)
    print(f"{real_s:.3f} s of the chip in {spent_s:.4f} s of CPU: {times:.0f} times real time")


def main(arguments: list[str] | None = None) -> int:
    """Run the command; 2: something that was given cannot be used, and standard error says what."""
    parser = argparse.ArgumentParser(
        prog="python -m hil.testing.sketch_trace",
        description="Run a compiled sketch, and write what comes out.",
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="has inputs.csv and expect.json")
    parser.add_argument("--hex", type=Path, metavar="FILE", help="the sketch; an ELF file does, too")
    parser.add_argument("-o", "--output", type=Path, metavar="TRACE", required=True, help="file to write")
    parser.add_argument("--stops", type=int, metavar="N", default=0, help="stop it each N cycles")
    options = parser.parse_args(arguments)
    if options.stops < 0:
        parser.error("--stops is a number of cycles")
    try:
        make_trace(options)
    except BadInput as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
