"""Texts of a SAC as data, for a companion that is no Python: ``READERS`` by the line that a screen answers,
or by the kind of file. Each is called with the text and the file's name, and raises DialogueError or Refusal.
"""

import re
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

from device_profiles.sac import screen_reading as screen
from device_profiles.sac.companion_files import FILE_BYTES, Row, read_one_shots, read_queue, read_row
from device_profiles.sac.long_files import MOST_BYTES, read_long_file
from hil.vocab.dialogue import DialogueError, Refusal

_MARK = "\xef\xbb\xbf"
_MOST_BYTES_TOLD = 10


def _rows(rows: Sequence[Row]) -> list[dict[str, int | bool]]:
    """Rows in the queue's order, which is their position."""
    return [
        {
            name: bool(value) if name.startswith("is_") else value
            for name, value in row._asdict().items()
            if name != "position"
        }
        for row in rows
    ]


def _listing(text: str, _: str) -> Mapping[str, Any]:
    rows, at = screen.read_listing(text.split("\n"))
    if not at:
        raise DialogueError("the listing does not say where the queue is")
    return {"rows": _rows(rows), "at": at}


def _configuration(text: str, _: str) -> Mapping[str, Any]:
    steps_per_rev = screen.number_on(text, screen.STEPS_PER_REV)
    if not steps_per_rev:
        raise DialogueError("no motor has 0 steps a turn")
    return {
        "steps_per_rev": steps_per_rev,
        "microstep_exponent": screen.number_on(text, screen.MICROSTEP_EXPONENT),
        "interrupt_overhead_us": screen.number_on(text, screen.INTERRUPT_OVERHEAD_US),
        "clock_correction_us": screen.number_on(text, screen.CLOCK_CORRECTION_US),
        "slow_rpm": screen.number_on(text, screen.SLOW_RPM),
        "is_network_swapped": re.search(r"E network\s+0*1\b", text) is not None,
    }


def _session(text: str, _: str) -> Mapping[str, Any]:
    cells = (line.split("\t") for line in text.split("\n") if "\t" in line)
    return {name: value for name, value, *_ in cells}


def _speed(text: str, _: str) -> Mapping[str, Any]:
    if (speed := screen.read_speed(text.split("\n"))) is None:
        raise DialogueError(f"this is no speed: {text[:80]!r}")
    return speed._asdict()


def _queue(text: str, file: str) -> Mapping[str, Any]:
    return {"rows": _rows(read_queue(_ascii(text, file), file).rows)}


def _one_shots(text: str, file: str) -> Mapping[str, Any]:
    return {"lines": read_one_shots(_ascii(text, file), file)}


def _long_file(text: str, file: str) -> Mapping[str, Any]:
    """Lines that move the motor, of a long file behind a first line with the motor's steps a turn."""
    steps, _, content = text.partition("\n")
    if not (steps.isascii() and steps.isdecimal() and int(steps[:10])):
        raise Refusal(f"{file}: no motor has {steps[:20]!r} steps a turn")
    long_file = read_long_file(_ascii(content, file, MOST_BYTES), file)
    long_file.check(int(steps))
    return {"moves": [row.motion(int(steps)) for row in long_file.rows]}


def _pasted(text: str, _: str) -> Mapping[str, Any]:
    """Rows of a spreadsheet or of a queue's file; their own positions do not count."""
    problems: list[str] = []
    lines = enumerate(re.split(r"\r?\n", text), 1)
    rows = [
        read_row(line.replace("\t", ","), str(number), problems) for number, line in lines if line.strip()
    ]
    if not rows:
        problems.append("there are no rows in the clipboard")
    if problems:
        raise Refusal("\n".join(re.sub(r"^(\d+):(\d+)", r"line \1, column \2", each) for each in problems))
    return {"rows": _rows([row for row in rows if row])}


def _ascii(text: str, file: str, most_bytes: int = FILE_BYTES) -> bytes:
    """Bytes of a file, each a character of ``text``.

    Raises:
        Refusal: some are neither printable ASCII nor TAB or a line's end, which readers of files leave alone.
    """
    if len(text) <= most_bytes:  # a longer one its reader refuses
        lines = text.removeprefix(_MARK).replace("\r\n", "\n").split("\n")
        told = (
            f"{file}:{number}:{wrong.start() + 1}:"
            f" the byte {ord(wrong[0]):#04x} is not ASCII text; take it out"
            for number, line in enumerate(lines, 1)
            for wrong in re.finditer(r"[^\t -~]", line)
        )
        if problems := list(islice(told, _MOST_BYTES_TOLD)):
            raise Refusal("\n".join(problems))
    return text.encode("latin-1", "replace")


READERS = {
    "q": _listing,
    "cc": _configuration,
    "cf": _session,
    "vd": _speed,
    "queue": _queue,
    "one_shots": _one_shots,
    "long_file": _long_file,
    "pasted": _pasted,
}
