"""Entry of the program ``hil``: the command line, or names for a shell's completion, which must be quick."""

import errno
import gc
import os
import signal
import sys
from types import ModuleType
from typing import Any

from hil import __version__

INTERRUPTED = 130
_NAME = "hil"  # also by `python -m hil`
_OF_ONE_THREAD = {"check", "list", "ready", "reload", "status"}
"""Verbs whose start is most of their time, and which have one thread: two that use a dataclass for the first
time at one moment would be in each other's way."""


def main() -> None:
    from hil.host.shown_stream import guard_streams

    guard_streams()
    if sys.argv[1:2] == ["_names"]:
        from hil.cli.documents.completion_names import print_names

        print_names(sys.argv[2:])
        return
    if None in (sys.stdin, sys.stdout, sys.stderr):
        from hil.host.journal import give_streams

        give_streams()
        guard_streams()
    is_serving, is_for_another = (_verb(sys.argv[1:]) == name for name in ("serve", "with-lines"))
    if not is_for_another:  # hil has no plugins: a look for them takes 4 %
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "true")
    if is_serving:
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})  # until the daemon knows what it means
        gc.disable()  # until it serves: an eighth of the start's time, for garbage that does not come
    elif not is_for_another:  # the program there handles signals in its own way, too
        gc.set_threshold(100_000)  # a short life: what imports make is no garbage
        # `serve` handles signals in its own way
        from hil.cli.framework.interrupts import end_by_signals

        end_by_signals()
    try:
        if sys.argv[1:] == ["--version"]:  # without the table of commands, which is most of its time
            print(f"hil {__version__}", flush=True)
            return
        if not (is_serving or is_for_another):
            if _verb(sys.argv[1:]) in _OF_ONE_THREAD:
                from hil.vocab.late_dataclass import make_later

                make_later()
            _put_off_metadata()
        from hil.cli.framework.command_answers import wants_json
        from hil.cli.framework.command_group import app

        if wants_json():
            _answer_in_json(app)
        app(prog_name=_NAME)
    except KeyboardInterrupt:  # outside of any command
        sys.exit(INTERRUPTED)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT) or error.filename is not None:
            raise
        sys.stdout = None  # what is left in it cannot be written either
        sys.exit(f"hil: standard output: {error.strerror}")
    finally:
        gc.freeze()  # memory ends with the process: a last look for garbage takes a sixth of `hil check`
        if not is_serving:  # nothing is left to be ended in order, and a traceback of the exit helps nobody
            signal.signal(signal.SIGINT, signal.SIG_DFL)


class _PutOff(ModuleType):
    """Module that is executed when a name in it is first used."""

    def __getattr__(self, name: str) -> Any:
        self.execute()
        return getattr(self, name)

    def execute(self) -> None:
        """Execute the module, if it was not."""
        if type(self) is _PutOff:
            self.__class__ = ModuleType  # type: ignore[assignment]
            self.__spec__.loader.exec_module(self)  # type: ignore[union-attr]


def _put_off_metadata() -> None:
    """Let ``importlib.metadata`` be executed when it is used. pydantic takes ``entry_points`` from it to look
    for plugins, which are disabled."""
    import importlib.util as imports

    name = "importlib.metadata"
    if name in sys.modules or not (spec := imports.find_spec(name)):
        return
    module: Any = imports.module_from_spec(spec)
    module.__class__ = _PutOff

    def entry_points(**given: Any) -> Any:
        _PutOff.execute(module)
        return module.entry_points(**given)

    module.entry_points = entry_points
    sys.modules[name] = module


def _verb(words: list[str]) -> str:
    """First word that is no option, and no value of one."""
    while words and words[0].startswith("-"):
        words = words[2 if words[0] in ("-b", "--bench", "--runtime-dir") else 1 :]
    return words[0] if words else ""


def _answer_in_json(app: Any) -> None:
    """Run a command whose errors are told in JSON, too, and exit."""
    import typer

    from hil.cli.framework.command_answers import error_line
    from hil.cli.framework.usage_words import USAGE_ERROR

    try:
        code = app(standalone_mode=False, prog_name=_NAME)
    except USAGE_ERROR as error:
        print(error_line(error.format_message(), error.exit_code))
        code = error.exit_code
    except typer.Abort:
        code = INTERRUPTED
    sys.exit(code if isinstance(code, int) else 0)
