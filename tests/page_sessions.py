"""Sessions of the project's pages: the commands of a page, in order, as its reader types them.

A command stands in a block after ``$``, or ``#`` for root; its output stands below it. The output is compared
line by line. A line ``...`` stands for any lines, and patterns say what varies: in a page and in the output
they count as one word. A command without output below it is only carried out. A command that prints an error
exits with 1 or 2, all others with 0.
"""

import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import typer
from e2e_support import PATIENCE_S, Place, Server, until
from markdown_blocks import ROOT, blocks, fits
from typer.testing import CliRunner

from hil.cli.framework.command_group import app

_COMMENT = re.compile(r"\s#\s.*")
_PROMPT = re.compile(r"^([$#]) (\S.*)$")
_HIL = re.compile(r"(?:^|[|;&] *)hil (?!reference)([a-z-](?:'[^']*'|[^|;&>'])*)")
_ERROR = re.compile(r"^(?:hil: |\S+\.yaml:\d+:\d+: )", re.M)
COLUMNS = "150"


BECOME_OTHERS = ("virtual", "with-lines")
"""Commands in whose place another program goes on."""


class Step(NamedTuple):
    """Command of a page, and what the page shows below it."""

    page: str
    heading: str
    is_root: bool
    command: str
    shown: str


def steps(page: str) -> list[Step]:
    """Commands of a page in order. A line that ends with a backslash goes on in the next."""
    found: list[Step] = []
    for each in blocks(page):
        if each.language not in ("console", "text", "sh", ""):
            continue
        lines = iter(each.text.splitlines(keepends=True))
        is_session = each.text.startswith(("$ ", "# ")) or each.language == "console"
        for line in lines if is_session else ():
            if prompt := _PROMPT.match(line):
                command = prompt[2]
                while command.endswith("\\"):
                    command = command[:-1] + next(lines).strip()
                found.append(Step(page, each.heading, prompt[1] == "#", command, ""))
            else:
                assert found, f"{page}: a session begins with a command, not with {line!r}"
                found[-1] = found[-1]._replace(shown=found[-1].shown + line)
    return found


def words_of(command: str) -> list[str]:
    """Split a command into words, as a shell does; in the middle of a word # begins no comment."""
    return shlex.split(_COMMENT.sub("", command))


def hil_lines(command: str) -> list[str]:
    """What comes behind ``hil`` in a line of a shell, for each ``hil`` in it."""
    return [_COMMENT.sub("", found) for found in _HIL.findall(command)]


def parsed(words: list[str]) -> None:
    """Parse a command line of hil, and carry nothing out. Raises what the command line raises."""
    command: Any = typer.main.get_command(app)
    with suppress(typer.Exit):  # as of --version
        context = command.make_context("hil", words)
        while hasattr(command, "commands") and (rest := [*context._protected_args, *context.args]):
            name, command, rest = command.resolve_command(context, rest)
            context = command.make_context(name, rest, parent=context)


class Session:
    """Reader of one page, in a folder of his own, with ``examples`` and ``wireshark`` of a checkout in it.

    ``swaps`` are texts of the page and what stands for them here, such as port numbers that are free.
    ``varies`` are patterns of what is different each time.
    """

    def __init__(self, place: Place, page: str) -> None:
        self.place, self.page = place, page
        self.folder = place.folder
        place.runtime, place.state = self.folder / "run" / "hil", self.folder / "state" / "hil"
        self.swaps: dict[str, str] = {
            "/run/user/1000": str(self.folder / "run"),
            "/home/you": str(self.folder),
        }
        self.varies: tuple[str, ...] = ()
        self.servers: list[Server] = []
        self._processes: list[subprocess.Popen[str]] = []
        for name in ("examples", "wireshark"):
            (self.folder / name).symlink_to(ROOT / name)
        self.environment = os.environ | {
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "XDG_RUNTIME_DIR": str(self.folder / "run"),
            "XDG_STATE_HOME": str(self.folder / "state"),
            "HOME": str(self.folder),
            "COLUMNS": COLUMNS,
            "TERM": "dumb",
        }

    def here(self, text: str) -> str:
        """Text of the page with what stands for it here."""
        for shown, real in self.swaps.items():
            text = text.replace(shown, real)
        return text

    def text(self, heading: str, language: str = "yaml", index: int = 0) -> str:
        """Block of the page, counted below its heading by language."""
        found = [e.text for e in blocks(self.page) if (e.heading, e.language) == (heading, language)]
        return self.here(found[index])

    def program(self, heading: str) -> str:
        """Run the Python below a heading, and return what it prints."""
        return self.run(f"python -c {shlex.quote(self.text(heading, 'python'))}")

    def write(self, name: str, text: str) -> Path:
        return self.place.write(self.here(text), name)

    def serve(
        self, text: str, *options: str, speed: float = 20, beside: bool = False, waits: bool = True
    ) -> Server:
        """Run a bench of this text until its boards answer, or its ports are there if it ``waits`` not; the
        benches before it end, unless it is to run beside them."""
        if not beside:
            self.end_benches()
        (name,) = re.findall(r"^bench: (\w+)", text, re.M)
        text = self.here(text) + (f"\nspeed: {speed}\n" if speed != 1 else "")
        launched = self.place.launch(text, *options, bench=name, cwd=self.folder, env=self.environment)
        self.servers.append(launched)
        return launched.started().ready() if waits else launched.started()

    def end_benches(self) -> None:
        for server in self.servers:
            if server.process.poll() is None:
                server.stop()
        self.servers.clear()

    def beside(self, command: str) -> str:
        """Start a command that goes on, and return its first line. It ends with the session."""
        process = subprocess.Popen(
            shlex.split(command), cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, text=True
        )
        self._processes.append(process)
        assert process.stdout
        return process.stdout.readline()

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            process.kill()
            process.communicate()

    def run(self, command: str) -> str:
        """Carry out a command, and return what it prints; its exit code has to fit that."""
        words = words_of(command)
        if words[:2] == ["hil", "serve"]:
            file, *options = [word for word in words[2:] if word != "&"]
            return self.serve((self.folder / file).read_text(), *options).output
        code, said = self.ended(command)
        assert (code in (1, 2)) == bool(_ERROR.search(said)), f"{command}: exit code {code}: {said}"
        return said

    def ended(self, command: str) -> tuple[int, str]:
        """Carry out a command that ends by itself; return its exit code and what it prints. One of hil alone
        runs in this process, unless it becomes another program."""
        words = words_of(command)
        if words[0] == "hil" and words[1] not in BECOME_OTHERS and not re.search(r"[|;&<>]", command):
            environment = {**self.environment, "COLUMNS": COLUMNS}
            done = CliRunner().invoke(app, words[1:], env=environment)
            assert done.exception is None or isinstance(done.exception, SystemExit), done.exc_info
            code, said = done.exit_code, done.output
        else:
            shell = subprocess.run(
                ["bash", "-c", command], cwd=self.folder, env=self.environment, timeout=PATIENCE_S,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
            )  # fmt: skip
            code, said = shell.returncode, shell.stdout
        return code, said

    def check(self, step: Step, carry_out: Callable[["Session", str], str] | None = None) -> None:
        """Carry out a step, and compare what it prints with the page."""
        command = self.here(step.command)
        said = carry_out(self, command) if carry_out else self.run(command)
        if step.shown:
            assert fits(self.here(step.shown), said, *self.varies), f"$ {command}\n{said}"


def _hear_ctrl_c() -> None:
    """Let a program end by Ctrl-C, as in a terminal: tests that run in a shell's background ignore it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def interrupted(session: Session, command: str, is_done: Callable[[str], bool]) -> str:
    """Start a command, and wait for its end, or until what it has printed says that it is done: then press
    Ctrl-C."""
    said = session.folder / "said.txt"
    with said.open("w") as file, subprocess.Popen(
        ["bash", "-c", command], cwd=session.folder, env=session.environment,
        stdout=file, stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=_hear_ctrl_c,
    ) as going_on:  # fmt: skip
        try:
            until(lambda: going_on.poll() is not None or is_done(said.read_text()), f"what {command} does")
            if going_on.poll() is None:
                os.killpg(going_on.pid, signal.SIGINT)
            going_on.wait(PATIENCE_S)
        finally:
            if going_on.poll() is None:
                os.killpg(going_on.pid, signal.SIGKILL)
    return said.read_text()


def captured(session: Session, command: str, talk: Callable[[], None], lines: int = 3) -> str:
    """Capture a talk, until ``lines`` lines of it stand in the command's file, or in its output without one.
    With a count of packets (``-c``), repeat the talk until the command ends."""
    file, has_talked, is_counting = re.search(r"-w (\w\S+)", command), False, " -c " in command

    def is_shown(said: str) -> bool:
        nonlocal has_talked
        if ("capturing" in said or "line watch" in command) and (is_counting or not has_talked):
            talk()
            has_talked = True
        elif has_talked and file:
            said = session.run(f"hil decode {file[1]} 2>/dev/null | cat")
        return has_talked and said.count("\n") >= lines and not is_counting

    return interrupted(session, command, is_shown)


def inline_commands(page: str) -> Iterator[str]:
    """Commands of hil in a page's code spans, without ``hil``."""
    text = re.sub(r"^```.*?^```", "", (ROOT / page).read_text(), flags=re.M | re.S)
    for span in re.findall(r"``? ?([^`]+?) ?``?", text):
        yield from hil_lines(re.sub(r"\s+", " ", span).replace("\\|", "|"))
