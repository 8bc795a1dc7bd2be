"""Python programs on this computer, by a path or by a name on ``PATH``."""

from pathlib import Path
from shutil import which

_FIRST_BYTES = 256


class NoPythonProgram(Exception):
    """Error of a name that is no Python program's: ``str(error)`` says why, in one line."""


def is_python(name: str) -> bool:
    """True for a Python interpreter by its name."""
    return Path(name).name.startswith("python")


def find_program(name: str) -> str:
    """Path of a program of any kind. Raises NoPythonProgram: there is none."""
    path = name if Path(name).is_file() else which(name)
    if path is None:
        raise NoPythonProgram(f"{name}: there is no such program, here or on PATH; write its path")
    return path


def find_python_program(name: str) -> str:
    """Path of a Python program.

    Raises:
        NoPythonProgram: there is none, or it is another kind of program.
    """
    path = find_program(name)
    if path.endswith(".py"):
        return path
    with Path(path).open("rb") as file:
        first = file.read(_FIRST_BYTES).partition(b"\n")[0]
    if not first.startswith(b"#!") or b"python" not in first:
        raise NoPythonProgram(
            f"{path} is no Python program: only these can live on simulated time; run others at a bench in"
            " real time, `hil serve`"
        )
    return path
