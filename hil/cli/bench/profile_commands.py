"""``hil profile``: which boards there are, a new one, and the checks that each has to pass."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer

if TYPE_CHECKING:
    from hil.config import BenchConfig
    from hil.vocab.problem import Problem

_OF_HIL = "device_profiles."
"""Beginning of the packages of hil's own boards, which are whole, and need not be tried."""
NAME = "[a-z][a-z0-9_]{0,31}"


def list_profiles(
    folders: Annotated[
        list[Path] | None,
        typer.Option("--folder", help="A folder with your own boards, as in profile_path."),
    ] = None,
) -> CommandAnswer:
    """List the boards that a configuration can name, with their folders.

    Example: hil profile list
    """
    from hil.cli.framework.problem_lines import tell_problems
    from hil.compose import find_catalogue
    from hil.discovery.board_places import find_places

    path = tuple(folder.resolve() for folder in folders or ())
    found, catalogue = find_places(path), find_catalogue(path=path)
    for message, remedy in found.wrong_paths.values():
        typer.echo(f"hil: {message} ({remedy})", err=True)
    rows = []
    for name in sorted({*found.places, *catalogue.refused}):
        problems = catalogue.problems(name)
        for problem in problems:
            tell_problems(str(problem))
        title = "cannot be used" if problems else catalogue.profiles[name].title
        origin = found.places[name].origin if name in found.places else "an entry point"
        rows.append({"profile": name, "title": title, "origin": origin, "usable": not problems})
    lines = [f"{row['profile']}: {row['title']} ({row['origin']})" for row in rows]
    return CommandAnswer(rows, "\n".join(lines))


def list_motors() -> CommandAnswer:
    """List the motors that a configuration can name as `motor`, with the figures of their data sheets.

    Example: hil profile motors
    """
    from hil.config.motors import MOTORS, motor_lines, own_figures

    rows = [
        {"motor": name, "title": motor.title, "rated_A": motor.rated_A, "steps": motor.steps}
        | own_figures(name, "full")
        for name, motor in MOTORS.items()
    ]
    return CommandAnswer(rows, "\n".join(motor_lines()))


def new(
    name: Annotated[
        str, typer.Argument(help="Its name: a letter a-z, then up to 31 characters of a-z, 0-9 and _.")
    ],
    folder: Annotated[Path, typer.Option("--folder", help="The folder for the board's folder.")] = Path(),
) -> CommandAnswer:
    """Write a new board: a folder with a board that runs and passes its tests.

    Example: hil profile new pinger --folder boards
    """
    from hil.cli.bench.new_board import files_of
    from hil.discovery.board_places import find_places
    from hil.host.new_file import write_file

    if not re.fullmatch(NAME, name):
        raise fail(f"hil: {name!r} is not a name; write a letter a-z and up to 31 more of a-z, 0-9 and _", 2)
    if place := find_places().places.get(name):
        raise fail(f"hil: there is a board {name} already, {place.origin}: choose another name", 2)
    board = folder / name
    try:
        if board.exists():
            raise fail(f"hil: {board} is there already; choose another name, or remove it", 2)
        files = files_of(name, str(folder))
        for file in files:
            (board / file).parent.mkdir(parents=True, exist_ok=True)
        for file, text in files.items():
            write_file(board / file, text.encode())
    except OSError as error:
        raise fail(f"hil: {error.filename or board}: {error.strerror}", 2) from None
    lines = [
        f"{board}: {', '.join(files)}",
        f"Try it: hil profile check {board}, and python -m pytest {board}",
        f"Use it: profile_path: [{folder}] in a configuration beside it, and profile: {name}",
    ]
    return CommandAnswer({"folder": str(board), "files": list(files)}, "\n".join(lines))


def check(
    folder: Annotated[Path, typer.Argument(help="The board's folder.", show_default=False)],
    sessions: Annotated[
        Path | None,
        typer.Option("--sessions", help="Also play the recorded sessions (*.json) of this folder or file."),
    ] = None,
) -> CommandAnswer:
    """Check a board by the rules for all boards.

    It loads and powers up, does the same with the same bytes whatever pieces they come in, survives garbage,
    starts again after a reset, and its log replays identically. With --sessions it also answers as recordings
    of it say. Exits with 1 if one fails. A warning is about what a real board might not do.

    Example: hil profile check boards/pinger
    """
    from hil.cli.framework.progress_bars import bar
    from hil.testing.profile_check import profile_failures

    if folder.is_file():
        raise fail(f"hil: {folder} is a file; give the board's folder, as `hil profile list` shows them", 2)
    if not folder.is_dir():
        raise fail(
            f"hil: there is no folder {folder}; write that of a board, as `hil profile list` shows them", 2
        )
    if problems := _problems(folder):
        raise fail("\n".join(map(str, problems)), 2)
    with bar(f"{folder} is checked"):
        failures = list(profile_failures(folder))
    played = _played(folder, sessions, failures) if sessions and not failures else 0
    if failures:
        raise fail("\n".join(failures))
    also = f", and {played} recorded sessions are as they were" if sessions else ""
    warnings = _warnings(folder)
    answer = {"folder": str(folder), "passes": True, "sessions": played, "warnings": warnings}
    return CommandAnswer(answer, "\n".join([*warnings, f"{folder}: passes all checks{also}"]))


def _problems(folder: Path) -> list["Problem"]:
    """Problems of the files of a board, or that there is none in its folder."""
    from hil.compose import find_catalogue
    from hil.discovery.board_places import MAKE_ONE

    place = folder.resolve()
    catalogue = find_catalogue(path=[place.parent])
    if problems := catalogue.problems(place.name):
        return [*problems]
    if place.name in catalogue.profiles:
        return []
    inside = sorted(find_catalogue(path=[place]).profiles.keys() - catalogue.profiles.keys())
    if inside:
        raise fail(f"{folder} is no board, there are boards in it; check one, as {folder / inside[0]}", 2)
    raise fail(f"{folder} is no board; {MAKE_ONE}", 2)


def _warnings(folder: Path) -> list[str]:
    from hil.compose import find_catalogue

    folder = folder.resolve()
    return [*map(str, find_catalogue(path=[folder.parent]).profiles[folder.name].warnings)]


def _played(folder: Path, sessions: Path, failures: list[str]) -> int:
    """Play sessions; answers how many. What differs is added to the failures."""
    from hil.cli.framework.progress_bars import bar
    from hil.testing.session_player import play, session_files
    from hil.vocab.recorded_session import SessionRefused

    try:
        files = session_files(sessions)
        with bar(f"{folder} is compared", "sessions") as shown:
            for count, file in enumerate(files):
                shown.tell(count, len(files))
                failures += map(str, play(file, profile=folder.resolve().name, folder=folder))
    except SessionRefused as error:
        raise fail(f"hil: {error}", 2) from None
    except OSError as error:
        raise fail(f"hil: {error.filename or sessions}: {error.strerror}", 2) from None
    return len(files)


def say_what_is_spoilt(bench: "BenchConfig") -> str:
    """Print the problems of boards that a bench does not use; answers their names as the end of a message."""
    from hil.compose import find_catalogue
    from hil.discovery.board_places import find_places

    catalogue, found = find_catalogue(path=bench.profile_path), find_places(bench.profile_path)
    of_hil = {name for name, place in found.places.items() if place.package.startswith(_OF_HIL)}
    used = {each.profile for each in bench.devices.values()}
    others = {*found.places, *found.refused} - used - (of_hil - found.refused.keys())
    spoilt = {name: problems for name in sorted(others) if (problems := catalogue.problems(name))}
    if spoilt:
        from hil.cli.framework.problem_lines import tell_problems

        for problem in (each for problems in spoilt.values() for each in problems):
            tell_problems(str(problem))
    return f"; not used and not usable: {', '.join(spoilt)}" if spoilt else ""
