"""Keywords of a program that runs at the bench of a test."""

from datetime import timedelta

from robot.api import Failure

from hil.robot.bench_kind import AtBench, StartedProgram, refusals, suite_folder
from hil.testing import ProgramRunsOn
from hil.vocab.time import NS_PER_MS, NS_PER_S

_SECOND = timedelta(seconds=1)
_MINUTE = timedelta(minutes=1)
LOOK_S = 0.01
"""Simulated time between two looks at what a program says."""
_MS_PER_S = NS_PER_S / NS_PER_MS


class ProgramKeywords(AtBench):
    """Keywords of the program that is tested."""

    def __init__(self) -> None:
        self._program: StartedProgram | None = None

    def start_program(self, program: str, *arguments: str, map: dict[str, str] | None = None) -> None:
        """Start a program that opens ports of the bench; it goes on beside the test.

        Its arguments have names of ports, or names of ``map``, a dictionary of the bench's ports by names
        that the program knows. In memory it has to be a Python program, and its time is that of the bench:
        it goes on in keywords that wait. The path begins in the folder of the suite.

        | Start Program    home.py    s1    400
        | Program Should Say    at 400    within=10 s
        | Program Should End    code=0
        """
        folder = suite_folder().absolute()
        path = str(folder / program) if (folder / program).is_file() else program
        with refusals():
            self._program = self._kind.start_program([path, *arguments], map or {}, folder)

    def program_should_say(self, text: str, within: timedelta = _SECOND) -> None:
        """Wait until the program has written ``text``, to its output or its error output.

        | Program Should Say    home    within=20 s
        """
        program, end_s = self._started(), self._kind.now_s + within.total_seconds()
        while text not in program.stdout + program.stderr:
            if not program.is_running:
                raise Failure(f"the program has ended with {program.returncode}; {_said(program)}")
            if self._kind.now_s >= end_s:
                raise Failure(f"{text!r} did not come within {within.total_seconds():g} s; {_said(program)}")
            self._kind.pass_time(LOOK_S)

    def program_should_end(self, code: int = 0, within: timedelta = _MINUTE) -> str:
        """Wait until the program ends, with this exit code. Answers what it has written to its output.

        | Program Should End    code=1    within=30 s
        """
        program = self._started()
        try:
            ended = program.wait(within.total_seconds() * _MS_PER_S)
        except ProgramRunsOn as error:
            raise Failure(f"{error}; {_said(program)}") from None
        if ended != code:
            raise Failure(f"the program has ended with {ended}, not with {code}; {_said(program)}")
        return program.stdout

    def _started(self) -> StartedProgram:
        if self._program is None:
            raise Failure("no program was started: `Start Program` comes first")
        return self._program


def _said(program: StartedProgram) -> str:
    text = (program.stdout + program.stderr).strip()
    return f"what it said:\n{text}" if text else "it said nothing"
