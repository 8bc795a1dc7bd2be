"""``hil sketch load``, ``reset``, ``pins``, ``registers`` and ``stack``."""

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_view import Grid, Line, ShownView, line
from hil.cli.sketch.program_files import Elf, loadable, need_symbols, symbols_of
from hil.sketch.chip import DATA_AT, RAM
from hil.sketch.function_names import Functions
from hil.sketch.register_names import (
    FLAGS,
    GENERAL,
    IO_REGISTERS,
    STACK_POINTER,
    STATUS,
    ChipRegister,
    value_of,
)
from hil.vocab.near_words import meant

SRAM_AT, STACK_TOP = RAM.start - DATA_AT, RAM.end - 1 - DATA_AT


def load(
    device: DeviceName,
    file: Annotated[Path, typer.Argument(help="Its .hex or .elf.", show_default=False)],
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Load a program into a board of a running bench; it starts at once.

    The board keeps it, as after an upload over its port. The names of functions come along, from
    the .elf or from one beside the .hex.

    Example: hil sketch load u1 sketches/blink/build/blink.elf
    """
    content = base64.b64encode(loadable(file)).decode()
    answer = bench.ask("load_program", device=device, program=content, file=file.name)
    return CommandAnswer(answer, f"{device} runs {answer['program']}")


def reset(device: DeviceName, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Switch a board off and on; its program starts again.

    Example: hil reset u1
    """
    return CommandAnswer(bench.ask("reset", device=device), f"{device}: off and on again")


def pins(device: DeviceName, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Show the pins of a board: direction, level, pull-up, PWM, and what is wired to each.

    Example: hil sketch pins u1
    """
    rows = bench.ask("processor", device=device)["pins"]
    columns = ("pin", "is", "level", "PWM", "wired to")
    table = [
        (
            name,
            "output" if row["is_output"] else "input, pull-up" if row["has_pull_up"] else "input",
            str(row["level"]),
            "" if row["duty"] is None else f"{100 * row['duty']:.1f} %",
            ", ".join(row["wired"]),
        )
        for name, row in rows.items()
    ]
    return CommandAnswer(rows, ShownView(Grid(columns, ("pin", "is", "wired to"), table)).text())


def registers(
    device: DeviceName,
    names: Annotated[
        list[str] | None, typer.Argument(help="As in TCNT1 PORTB r24; left out: all.", show_default=False)
    ] = None,
    elf: Elf = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Show the registers of a board's processor, by name.

    Example: hil sketch registers u1 TCCR1A TCCR1B TCNT1 OCR1A
    """
    chip = bench.ask("processor", device=device)
    data = bytes.fromhex(chip["data"])
    known = {each.name.lower(): each for each in (*GENERAL, STACK_POINTER, STATUS, *IO_REGISTERS)}
    if wrong := next((name for name in names or () if name.lower() not in (*known, "pc")), None):
        every = [*(each.name for each in known.values()), "PC"]
        raise fail(f"hil: there is no register {wrong!r}; {meant(wrong, every)}", Exit.MISTAKE)
    asked = [known[name.lower()] for name in names or () if name.lower() != "pc"]
    if names and "pc" not in map(str.lower, names):
        shown, head = asked, []
    else:
        where = Functions(symbols_of(chip, elf)).name_at(chip["pc"])
        shown = asked if names else [STACK_POINTER, STATUS, *GENERAL, *IO_REGISTERS]
        head = [line(f"PC 0x{chip['pc']:04X}{f', in {where}' if where else ''}, cycle {chip['cycles']:,}")]
    values = {each.name: value_of(each, data) for each in shown}
    if head:
        values["PC"] = chip["pc"]
    return CommandAnswer(values, ShownView(*head, *_tables(shown, data)).text())


def _tables(shown: list[ChipRegister], data: bytes) -> Iterator[Line | Grid]:
    """Registers below the parts of the chip that they belong to."""
    columns = ("register", "address", "hex", "decimal", "bits")
    for part in dict.fromkeys(each.part for each in shown):
        yield line(part, "italic")
        rows = [
            (
                each.name,
                f"0x{each.address:02X}",
                f"0x{value:0{2 * each.bytes}X}",
                str(value),
                _bits(each, value),
            )
            for each in shown
            if each.part == part
            for value in (value_of(each, data),)
        ]
        yield Grid(columns, ("register", "bits"), rows)


def _bits(register: ChipRegister, value: int) -> str:
    if register is STATUS:
        return "".join(flag if value >> bit & 1 else "-" for bit, flag in enumerate(FLAGS))[::-1]
    return f"{value:0{8 * register.bytes}b}"


def stack(device: DeviceName, elf: Elf = None, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Show how far the stack has come down, the heap, and what is free between them.

    The stack's lowest address is that of a byte that was put on it, since the reset. What is free is from the
    heap's end, or that of the variables, to there. Needs the program's symbols.

    Example: hil sketch stack u1
    """
    chip = bench.ask("processor", device=device)
    symbols = {each.name: each for each in need_symbols(chip, elf)}
    data = bytes.fromhex(chip["data"])
    if (heap := symbols.get("__heap_start") or symbols.get("_end")) is None:
        raise fail(
            f"hil: the program of {device} has no __heap_start: where its variables end is not known", 1
        )
    end = begin = heap.address - DATA_AT
    if brkval := symbols.get("__brkval"):
        at = brkval.address - DATA_AT
        end = int.from_bytes(data[at : at + 2], "little") or begin
    lowest = min(chip["stack_lowest"], STACK_TOP + 1)
    pointer = value_of(STACK_POINTER, data)
    answer = {
        "stack_pointer": pointer,
        "stack_lowest": lowest,
        "stack_bytes": STACK_TOP + 1 - lowest,
        "heap_start": begin,
        "heap_end": end,
        "free_bytes": lowest - end,
    }
    return CommandAnswer(answer, "\n".join(_stack_lines(answer)))


def _stack_lines(answer: dict[str, Any]) -> Iterator[str]:
    lowest, begin, end = answer["stack_lowest"], answer["heap_start"], answer["heap_end"]
    now = f"now at 0x{answer['stack_pointer']:04X}"
    yield f"stack      0x{lowest:04X} to 0x{STACK_TOP:04X} at most, {answer['stack_bytes']} bytes; {now}"
    heap = f"0x{begin:04X} to 0x{end - 1:04X}, {end - begin} bytes" if end > begin else "none"
    yield f"heap       {heap}"
    yield f"variables  0x{SRAM_AT:04X} to 0x{begin - 1:04X}, {begin - SRAM_AT} bytes"
    free = answer["free_bytes"]
    yield (
        f"free       {free} bytes" if free >= 0 else f"free       none: the stack went {-free} bytes too far"
    )
