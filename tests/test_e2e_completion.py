"""Completion, asked of the shells themselves, beside a bench that runs."""

import os
import pty
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest
from e2e_support import HIL, TERMINAL, Place, config, until

from hil.cli.documents.command_tree import commands
from hil.cli.documents.completion_names import KINDS
from hil.cli.framework.command_group import app
from hil.cli.framework.command_table import VALUES

SAC = {"profile": "sac", "flash": {}, "network": {"kind": "pty"}}
BASH = """
compopt() { :; }
source "$1"
shift
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_hil hil "${!#}" ""
printf '%s\\n' "${COMPREPLY[@]}"
"""
ZSH = """
autoload -U compinit
compinit -u -D
source ./hil.zsh
compadd() {
    local -a hits
    # -O, -A and -D ask what would match, and add nothing.
    if [[ ${@[1,(i)-(-|)]} != *-[OAD]* ]]; then
        builtin compadd -A hits "$@"
        print -rl -- $hits >> found
    fi
    builtin compadd "$@"
}
probe() { _main_complete; print DONE >> found }
zle -C probe complete-word probe
bindkey '^X' probe
touch ready
"""
LINES: dict[str, set[str]] = {
    "hil se": {"seeds", "serve", "set"},
    "hil fault i": {"inject"},
    "hil -b t fault i": {"inject"},
    "hil --bench t status s": {"s1", "s2"},
    "hil docs zen": {"zenoh"},
    "hil completion ": {"bash", "zsh", "fish"},
    "hil status --j": {"--json"},
    "hil reset ": {"m1", "s1", "s2"},
    "hil reset --bench ": {"t"},
    "hil monitor s1.": {"s1.network"},
    "hil capture s1 bus": {"bus0", "bus0.master"},
    "hil line play bench.yaml ": {"bus0.master"},
    "hil axis m1 move": {"move-abs", "move-rel"},
    "hil axis m1 move-abs pos": {"position_deg="},
    "hil axis m1 move-abs 90 vel": {"velocity_rpm="},
    "hil fault inject byte_f": {"byte_flip"},
    "hil fault inject byte_flip s1 rate=0.1 see": {"seed="},
    "hil fault clear ": {"1"},
    "hil parity sac/id": {"sac/identify"},
    "hil parity --profile mech": {"mechaduino"},
    "hil check --diff t.y": {"t.yaml"},
    "hil run l": {"list"},
    "hil run t.y": {"t.yaml"},
    "hil run t.yaml --det": {"--detach"},
    "hil run list --j": {"--json"},
    "hil stop s": {"s1", "s2"},
    "hil top m1.pos": {"m1.position_deg"},
    "hil fault kinds mot": {"motor", "motor_power_off", "motor_unplugged"},
    "hil line sc": {"scan"},
    "hil gcode --mach": {"--machine"},
    "hil moth": set(),
    "hil serve t.y": {"t.yaml"},
    "hil serve --runtime-dir ru": {"run"},
}
"""Lines that are typed, and what is offered for the last word of each."""


def environment(place: Place) -> dict[str, str]:
    path = f"{Path(HIL).parent}:{os.environ['PATH']}"
    return os.environ | TERMINAL | {"XDG_RUNTIME_DIR": str(place.folder / "run"), "PATH": path}


@pytest.fixture
def folder(place: Place) -> Place:
    """A place with a bench in ``run/hil`` (as ``$XDG_RUNTIME_DIR`` has it) that has one of everything."""
    place.runtime = place.folder / "run" / "hil"
    devices = {"m1": {}, "s1": SAC, "s2": {"profile": "sac", "flash": {}}}
    segments = {"bus0": {"stations": ["s2"], "taps": {"master": {"port": "pty"}}}}
    server = place.serve(config(devices=devices, segments=segments))
    server.ask("inject", fault="byte_drop", target="m1", parameters={"rate": 0.0})
    return place


def completion(place: Place, shell: str) -> Path:
    script = place.folder / f"hil.{shell}"
    return script if script.exists() else place.write(place.cli("completion", shell), script.name)


def offered_by_bash(place: Place, line: str) -> set[str]:
    script = completion(place, "bash")
    done = subprocess.run(
        ["bash", "-c", BASH, "bash", str(script), *line.split(" ")],
        cwd=place.folder, env=environment(place), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stderr == ""
    return {word for word in done.stdout.split("\n") if word}


def offered_by_fish(place: Place, line: str) -> set[str]:
    script = completion(place, "fish")
    done = subprocess.run(
        ["fish", "--no-config", "-c", f"source {script}; complete -C '{line}'"],
        cwd=place.folder, env=environment(place), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stderr == ""
    start = line.rpartition(" ")[2]
    words = {row.split("\t")[0].rstrip("/") for row in done.stdout.splitlines()}
    return {word for word in words if word.startswith(start)}  # fish offers what only contains it, too


@contextmanager
def zsh(place: Place) -> Iterator[Callable[[str], set[str]]]:
    """Function that answers the words that zsh offers for a line. It completes on a terminal only; what it
    would add there is written to a file."""
    completion(place, "zsh")
    setup = place.write(ZSH, "setup.zsh")
    ready, found = place.folder / "ready", place.folder / "found"
    terminal, inside = pty.openpty()
    shell = subprocess.Popen(
        ["zsh", "-f", "-i"],
        stdin=inside, stdout=inside, stderr=inside, cwd=place.folder, env=environment(place),
        start_new_session=True,
    )  # fmt: skip

    def offered(line: str) -> set[str]:
        found.unlink(missing_ok=True)
        os.write(terminal, b"\x15" + line.encode() + b"\x18")  # on a line that is empty again
        until(lambda: found.exists() and "DONE\n" in found.read_text(), f"what zsh offers for {line!r}")
        return {word.rstrip("/") for word in found.read_text().split("\n")} - {"DONE", ""}

    try:
        os.write(terminal, f"source {setup}\n".encode())
        until(ready.exists, "zsh")
        yield offered
    finally:
        shell.kill()
        shell.wait()
        os.close(terminal)
        os.close(inside)


@contextmanager
def each_time(ask: Callable[[Place, str], set[str]], place: Place) -> Iterator[Callable[[str], set[str]]]:
    yield partial(ask, place)


SHELLS = {
    "bash": partial(each_time, offered_by_bash),
    "fish": partial(each_time, offered_by_fish),
    "zsh": zsh,
}


@pytest.mark.parametrize("shell", SHELLS)
def test_shells_offer_what_there_is(folder: Place, shell: str) -> None:
    if not shutil.which(shell):
        pytest.skip(f"no {shell} here")
    with SHELLS[shell](folder) as offered:
        assert {line: offered(line) for line in LINES} == LINES


def test_names_of_other_benches_are_not_mixed(folder: Place) -> None:
    folder.serve(config(bench="u", devices={"m9": {}}), bench="u")
    assert folder.hil("_names", "devices", "reset", *folder.folders()[:2]) == ""
    chosen = folder.hil("_names", "devices", "reset", "--bench=u", *folder.folders()[:2])
    assert chosen == "m9\tmechaduino\n"


def test_without_a_bench_names_are_empty_and_no_error(place: Place) -> None:
    for kind in KINDS.keys() - {"boards", "fault-words", "faults", "pages", "sessions", "shells"}:
        assert place.hil("_names", kind, "axis", "m1", "reset", *place.folders()[:2]) == ""


def test_an_unknown_shell_is_refused(place: Place) -> None:
    assert "bash, zsh, fish" in place.cli("completion", "tcsh", code=2)


def test_each_kind_of_name_is_used_and_known() -> None:
    taken = {each.takes for command in commands(app).all() for each in (*command.arguments, *command.options)}
    assert taken == {each.takes for each in VALUES.values()}
    assert taken - {"", "file", "folder"} == set(KINDS)
