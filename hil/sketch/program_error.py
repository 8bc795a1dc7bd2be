"""Error of a program's file, with its place and its remedy."""

from hil.vocab.problem import Problem


class ProgramError(Exception):
    """Error of a file that is no program, or none for this chip. ``problem`` has the line and the column,
    from 1 on, in a text; 0 in a binary file."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(str(problem))
        self.problem = problem


def program_error(name: str, message: str, remedy: str, line: int = 0, column: int = 0) -> ProgramError:
    """Make the error of a file of this name."""
    return ProgramError(Problem(name, line, column, message, remedy))
