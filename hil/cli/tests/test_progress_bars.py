"""Bars of commands, as a terminal gets them: from a second on, gone at the end and at Ctrl-C."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.cli.framework.progress_bars import progress_words

SCRIPT = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
from hil.cli.framework.progress_bars import bar
with bar("m1 calibrates", "s simulated") as shown:
    shown.tell(12, 26)
    time.sleep(float(sys.argv[1]))
print("done")
"""
TERMINAL = {"TERM": "xterm-256color", "COLUMNS": "80"}
HIDE, SHOW = b"\x1b[?25l", b"\x1b[?25h"


def shown_in_a_terminal(seconds: float, *words: str, interrupts: bool = False) -> tuple[bytes, int]:
    terminal, inner = pty.openpty()
    command = [sys.executable, "-c", SCRIPT, str(seconds), *words]
    streams = {"stdin": inner, "stdout": inner, "stderr": inner}
    running = subprocess.Popen(command, **streams, env=os.environ | TERMINAL, start_new_session=True)
    os.close(inner)
    said, end_s = b"", time.monotonic() + 30
    while select.select([terminal], [], [], max(end_s - time.monotonic(), 0))[0]:
        try:
            said += os.read(terminal, 65536)
        except OSError:  # it has ended
            break
        if interrupts and b"12 of 26" in said:
            interrupts = False
            running.send_signal(signal.SIGINT)
    os.close(terminal)
    return said, running.wait(30)


@pytest.mark.long
def test_a_bar_comes_after_a_second_says_what_it_is_of_and_goes() -> None:
    said, code = shown_in_a_terminal(2.5)
    assert b"m1 calibrates: 12 of 26 s simulated" in said
    assert said.count(HIDE) == said.count(SHOW) == 1
    assert re.search(rb"\x1b\[2K(\x1b\[[^m]*m)?done\r\n$", said)
    assert code == 0


@pytest.mark.long
def test_ctrl_c_takes_the_bar_away() -> None:
    said, code = shown_in_a_terminal(30, interrupts=True)
    _, found, after = said.partition(b"12 of 26")
    assert found, said
    assert b"\x1b[2K" in after, said
    assert SHOW in after
    assert said.count(HIDE) == said.count(SHOW) == 1
    assert code == -signal.SIGINT


def test_what_is_quick_or_told_to_a_program_has_no_bar() -> None:
    assert shown_in_a_terminal(0.1) == (b"done\r\n", 0)


@pytest.mark.long
def test_json_and_pipes_have_no_bar() -> None:
    assert shown_in_a_terminal(1.5, "--json") == (b"done\r\n", 0)
    done = subprocess.run([sys.executable, "-c", SCRIPT, "1.5"], capture_output=True, env=os.environ)
    assert (done.stdout, done.stderr) == (b"done\n", b"")


def test_words_of_a_bar() -> None:
    assert progress_words("m1 calibrates", "s simulated", (12.3, 26.0), 1) == (
        "m1 calibrates: 12 of 26 s simulated"
    )
    assert progress_words("m1 moves", "s simulated", (0.25, 1.5), 1) == "m1 moves: 0.2 of 1.5 s simulated"
    assert progress_words("m1 moves", "s simulated", (3.4, 0), 1) == "m1 moves: 3 s simulated"
    assert progress_words("blink is built", "", None, 3.4) == "blink is built: 3 s"
    assert progress_words("a long name of a recording", "s", (1, 20), 1, 24) == "a long name …: 1 of 20 s"


@given(
    st.text(max_size=60),
    st.one_of(st.none(), st.tuples(st.floats(0, 1e6), st.floats(0.1, 1e6))),
    st.integers(40, 200),
)
def test_words_of_a_bar_fit(what: str, found: tuple[float, float] | None, columns: int) -> None:
    assert len(progress_words(what, "s simulated", found, 5.0, columns)) <= columns
