"""Names of recordings: what `hil recordings` lists is taken by all commands in place of a path."""

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from hil.compose.recordings_folder import RECORDINGS, recordings_in, run_name

_LAST = re.compile(r"last(?:-(\d{1,6}))?")
_SHOWN = 5
_FORMS = "write a path, last, last-1, BENCH/last, or the beginning of a name that `hil recordings` lists"


class NoSuchRecording(ValueError):
    """Error of a name that means no recording, or several: ``str(error)`` says which there are."""


def recordings_of(bases: Iterable[Path], bench: str | None = None) -> list[Path]:
    """Recordings in state directories, of all benches or one, by their dates, the oldest first. What may not
    be read is left out."""
    folders: list[Path] = []
    for base in bases:
        with suppress(OSError):
            folders += [base / bench] if bench else sorted(base.iterdir())
    found = [path for folder in folders for path in recordings_in(folder / RECORDINGS)]
    return sorted(found, key=run_name)


def bench_of(path: Path) -> str:
    """Name of the bench that a recording in a state directory is of."""
    return path.parent.parent.name


def found_recording(text: str, bases: Sequence[Path]) -> Path:
    """Find a recording by its path, or by its name in a state directory: ``last``, ``last-1`` (the one
    before), ``2026-11-29T00-09``, ``lab/last``.

    Raises:
        NoSuchRecording: there is none, or there are several.
    """
    path = Path(text)
    if text and (path.exists() or path.is_symlink()):
        return path
    bench, _, name = text.rpartition("/")
    if "/" in bench or path.is_absolute():
        raise NoSuchRecording(f"{text}: No such file or directory")
    there = recordings_of(bases, bench or None)
    if back := _LAST.fullmatch(name):
        if (number := int(back[1] or 0)) < len(there):
            return there[-1 - number]
        raise NoSuchRecording(f"{text}: {_there(there, bases, bench)}")
    found = [each for each in there if name and run_name(each).startswith(name)]
    if exact := [each for each in found if run_name(each) == name]:
        found = exact
    if len(found) == 1:
        return found[0]
    if found:
        raise NoSuchRecording(f"{text}: {len(found)} recordings begin so: {_names(found)}; write more of one")
    raise NoSuchRecording(f"{text}: No such file or directory, and no recording of this name; {_FORMS}")


def _there(there: list[Path], bases: Iterable[Path], bench: str) -> str:
    of = f" of {bench}" if bench else ""
    counts = {0: "there is no recording", 1: "there is one recording"}
    count = counts.get(len(there), f"there are {len(there)} recordings")
    return f"{count}{of} in {' and '.join(map(str, bases))}"


def _names(found: Iterable[Path]) -> str:
    names = [f"{bench_of(path)}/{run_name(path)}" for path in found]
    return ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
