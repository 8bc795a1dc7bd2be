"""Parts of commands that ask a running bench."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

if TYPE_CHECKING:
    from hil.net.benches_here import Found, Here

RuntimeDir = Annotated[
    Path | None,
    typer.Option(
        "--runtime-dir",
        help="Folder of running benches' ports and sockets."
        " [default: $XDG_RUNTIME_DIR/hil; commands that ask look in /run/hil too]",
    ),
]
Bench = Annotated[
    str | None,
    typer.Option(
        "--bench",
        "-b",
        help="The bench, by its name, its folder or service:NAME; needed when several are running, unless one"
        " alone has the device that is named.",
    ),
]
DeviceName = Annotated[
    str, typer.Argument(help="A device's name, as in the configuration.", show_default=False)
]


def fail(message: str, code: int = 1, sources: Mapping[str, str] | None = None) -> typer.Exit:
    """Print why a command fails, and answer the exception for it to raise. ``message``: what is wrong (what
    was given), where; what to do. `hil:` comes before it here. ``sources``: texts of files whose problems the
    message lists, if they cannot be read again."""
    from hil.cli.framework.command_answers import error_line, pasteable, wants_json
    from hil.cli.framework.problem_lines import with_remedy
    from hil.cli.framework.progress_bars import end_bars

    end_bars()
    message = pasteable(with_remedy(message.removeprefix("hil: ")))
    if wants_json():
        typer.echo(error_line(message, code))
    else:
        tell_error(message, sources)
    return typer.Exit(code)


def tell_error(message: str, sources: Mapping[str, str] | None = None) -> None:
    """Write to the standard error what is wrong, with `hil:` before it, and before problems of files a line
    that says what follows."""
    import logging
    import os

    from hil.cli.framework.problem_lines import headed, tell_problems
    from hil.host.journal import is_journal, prefixed, say

    message = headed(message)
    if is_journal(sys.stderr, os.environ):
        say(prefixed(message, logging.ERROR), sys.stderr)
    else:
        tell_problems(message, sources)


def found(runtime_dir: Path | None) -> "Found":
    """Find the benches that run here; says which folders are not looked into."""
    import os

    from hil.net.benches_here import find

    here = find(runtime_dir, os.environ).running()
    if here.benches and here.left_out:
        from hil.host.journal import say

        for left_out in here.left_out:
            say(f"hil: not looked into: {left_out}", sys.stderr)
    elif here.left_out:
        raise fail(f"hil: {here.none_runs()}")
    return here


def benches_meant(bench: str | None, here: "Found") -> list["Here"]:
    """Benches that are meant, at least one, or say what is wrong and end the command."""
    if not here.benches:
        raise fail(f"hil: {here.none_runs(bench)}")
    if not (meant := here.meant(bench)):
        import os

        said = here.not_running(str(bench))
        if bench == os.environ.get("HIL_BENCH") and not {"-b", "--bench"} & set(sys.argv):
            said += "; the variable HIL_BENCH names it: `unset HIL_BENCH`"
        raise fail(said)
    return meant


class BenchOptions(NamedTuple):
    """Options that say which bench is meant. Where something is wrong with it, the command ends and says
    what."""

    bench: Bench = None
    runtime_dir: RuntimeDir = None

    def meant(self) -> "Here":
        """Find the bench."""
        import os

        from hil.cli.framework.command_answers import ask_with

        here = found(self.runtime_dir)
        meant = benches_meant(self.bench, here)
        if len(meant) == 1:
            ask_with(here.options(meant[0].folder, self.runtime_dir, os.environ))
            return meant[0]
        from hil.cli.framework.named_bench import bench_of_names

        named, why = bench_of_names(meant, is_named=self.bench is not None)
        if named:
            ask_with(here.options(named.folder, self.runtime_dir, os.environ))
            return named
        lines = [f"  --bench {here.called(each)}: {each.line()}" for each in meant]
        raise fail("\n".join([why, *lines]), 2)

    def port_of(self, address: str) -> str:
        """Port's address as the bench said it, if it may have such a port."""
        from hil.host.trust import refuse_address

        if why := refuse_address(address, self.meant().owner):
            raise fail(f"hil: {address!r}, which the bench gave as a port's address: {why}")
        return address

    def ask(self, verb: str, **arguments: Any) -> Any:
        """Send one request."""
        from hil.cli.framework.exit_codes import exit_of
        from hil.cli.framework.usage_words import with_command
        from hil.net.control_client import ControlError, ask

        path = self.meant().socket
        try:
            return ask(path, verb, **arguments)
        except ControlError as error:
            why, of = str(error), arguments.get("device")
            if of and not error.is_mistake and not _names(why, str(of)):
                why = f"{of}: {why}"  # a board says what it cannot do now, and not which it is
            why = with_command(why, str(of or ""))
            if error.code == "no_device":
                from hil.cli.framework.named_bench import with_meaning

                why = with_meaning(path, str(of or ""), why)
            raise fail(why, exit_of(error)) from None


def _names(text: str, device: str) -> bool:
    """True if a text says which device it is about. A short name may be a word: `a`, `in`."""
    import re

    return text.startswith(device) or (len(device) > 2 and bool(re.search(rf"\b{re.escape(device)}\b", text)))


ANY_BENCH = BenchOptions()
