"""Watch on the files of programs that boards run: whether they have changed since the boards began."""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from hil.config.device_program import ProgramFile
from hil.host.regular_file import read_regular

_State = tuple[int, int, int]


@dataclass
class _Watched:
    file: ProgramFile
    state: _State | None = None
    """Time, size and number of the file at the last look."""
    note: str | None = None
    """Note that was made of it then."""
    is_seen: bool = field(default=False)


class ProgramWatch:
    """Watch on the files of one board. A look costs little while nothing has changed."""

    def __init__(self, files: Iterable[ProgramFile | None]) -> None:
        self._watched = [_Watched(file) for file in files if file]

    def notes(self) -> Iterator[str]:
        """Look, and say what has changed."""
        for each in self._watched:
            state = _state_of(each.file)
            if not each.is_seen or state != each.state:
                each.is_seen, each.state, each.note = True, state, _note(each.file)
            if each.note:
                yield each.note


def _state_of(file: ProgramFile) -> _State | None:
    try:
        found = os.stat(file.path)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def _note(file: ProgramFile) -> str | None:
    from hil.sketch.program_error import ProgramError

    try:
        if file.digest_of(read_regular(file.path)) == file.digest:
            return None
    except OSError as error:
        return f"{file} cannot be read any more ({error.strerror}); the board runs on with what it had"
    except ProgramError as error:
        return f"{file} has changed, and cannot be used: {error}; the board runs on with what it had"
    return f"{file} has changed; `hil reload` takes it"


NO_PROGRAMS = ProgramWatch(())
"""Watch of a board that runs no program of a file."""
