"""Exit codes of all commands: the one table, which the reference prints."""

from enum import IntEnum

from hil.net.control_client import ControlError
from hil.vocab.verbs import NOT_MISTAKES


class Exit(IntEnum):
    """Exit code of a command."""

    DONE = 0
    FAILED = 1
    MISTAKE = 2
    RUN_FAILED = 3
    RUN_CANCELLED = 4
    NOT_KNOWN = 5
    FIRMWARE_HUNG = 70
    INTERRUPTED = 130


EXIT_CODES: dict[int, str] = {
    Exit.DONE: "done; of `hil serve`: ended by Ctrl-C, SIGTERM or the verb `stop`",
    Exit.FAILED: "failure: no bench answers, the bench or the board refused"
    f" ({', '.join(f'`{code}`' for code in NOT_MISTAKES)}), a log differs, the doctor found a problem;"
    " of `hil seeds merge`: a test failed, or a shard is not there;"
    " of `hil capture`: the bench ended before it;"
    " of `hil type` and `hil wait`: what is awaited did not come in its time;"
    " of `hil find`: the condition never holds;"
    " of `hil parity`: board and twin part, or the board stopped answering;"
    " of `hil line`: a node refused a command, or none was found",
    Exit.MISTAKE: "a mistake, with which a retry does not help: an option or a name that does not exist, a"
    " value out of its limits (all other codes of refusals), or a configuration or a file with problems,"
    " which are listed; of `hil serve` and `hil parity`: something it needs is refused or in use",
    Exit.RUN_FAILED: "of `hil run` and `hil gcode`: it failed; the report says why, and where all"
    " axes were left",
    Exit.RUN_CANCELLED: "of `hil run`: somebody else cancelled the run",
    Exit.NOT_KNOWN: "of `hil line`: the outcome of a command is not known: it was carried out once, or not"
    " at all; of `hil gcode`: where an axis stands is not known",
    Exit.FIRMWARE_HUNG: "of `hil serve`: a firmware could not be interrupted; the next start names it",
    Exit.INTERRUPTED: "ended early by Ctrl-C or SIGTERM; `hil run` ends its run first",
}
"""Codes with their meanings."""


def exit_of(error: ControlError) -> Exit:
    """Exit code of a command whose request was refused."""
    return Exit.MISTAKE if error.is_mistake else Exit.FAILED
