"""The ways out to a terminal: what is anybody's text is harmless on all of them, colours and JSON stay."""

import io
import json
import logging
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import typer
from rich.table import Table
from rich.text import Text

import hil
from hil.cli.framework.consoles import ShownConsole
from hil.cli.framework.problem_lines import tell_problems
from hil.host.journal import say
from hil.host.log_writer import LogWriter
from hil.host.shown_stream import ShownStream, guard_streams, own

EVIL = "\x1b]0;PWNED\x07\x9b31m\u202e\x1b[2J"
ROOT = Path(hil.__file__).parents[1]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@contextmanager
def at_a_terminal() -> Iterator[Terminal]:
    made = Terminal()
    with pytest.MonkeyPatch.context() as patch:
        for name in ("NO_COLOR", "TERM"):
            patch.delenv(name, raising=False)
        for name in ("stdout", "stderr"):
            patch.setattr(sys, name, made)
        guard_streams()
        guard_streams()
        yield made


def unescaped(text: str) -> str:
    """Text without colours and without the control of rich."""
    return re.sub(r"\x1b\[[0-9;]*m", "", text)


def test_all_that_is_written_is_harmless() -> None:
    with at_a_terminal() as terminal:
        print(EVIL)
        typer.echo(EVIL)
        typer.echo(EVIL, err=True)
        say(EVIL, sys.stderr)
        sys.stdout.writelines([EVIL, "\n"])
        said = unescaped(terminal.getvalue())
        assert said.replace("\n", "").isprintable()
        assert said.count("PWNED") == 5


def test_consoles_are_harmless_and_have_colours() -> None:
    with at_a_terminal() as terminal:
        console = ShownConsole(force_terminal=True, width=200)
        table = Table(EVIL)
        table.add_row(Text(EVIL, style="red"))
        console.print(table)
        console.print(EVIL)
        said = terminal.getvalue()
        assert "\x1b[31m" in said
        assert unescaped(said).replace("\n", "").isprintable()
        assert "\\x1b]0;PWNED" in said


def test_problems_are_harmless_and_have_colours() -> None:
    with at_a_terminal() as terminal:
        tell_problems(f"x.yaml:1:2: {EVIL}", {"x.yaml": f"a{EVIL}"})
        assert "\x1b[1m" in terminal.getvalue()
        assert unescaped(terminal.getvalue()).replace("\n", "").isprintable()


def test_a_stream_is_what_it_was_for_all_else() -> None:
    with at_a_terminal() as terminal:
        stream = sys.stdout
        assert isinstance(stream, ShownStream)
        assert stream.isatty()
        assert own(stream) is terminal
        assert own(terminal) is terminal
        with pytest.raises(TypeError):
            stream.write(b"x")  # type: ignore[arg-type]
        answer = {"text": EVIL, "more": "ü\n"}
        print(json.dumps(answer))
        assert json.loads(terminal.getvalue()) == answer


def test_the_log_is_harmless() -> None:
    reader, writer = os.pipe()
    log = LogWriter(writer)
    log.emit(logging.makeLogRecord({"msg": EVIL}))
    log.write(writer, EVIL)
    log.close()
    os.close(writer)
    with os.fdopen(reader, "rb") as file:
        said = file.read().decode()
    assert said.count("PWNED") == 2
    assert said.replace("\n", "").isprintable()


def test_there_are_no_other_consoles() -> None:
    """A console of its own writes what it likes: those of ``hil.cli.framework.consoles`` do not."""
    folders = [ROOT / name for name in ("hil", "bridges", "device_profiles", "virtual_ports")]
    found = [
        str(path.relative_to(ROOT))
        for folder in folders
        for path in folder.rglob("*.py")
        if "tests" not in path.parts and re.search(r"(?<!Shown)\bConsole\(", path.read_text())
    ]
    assert found == []
