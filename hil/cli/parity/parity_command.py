"""``hil parity``: sessions that are typed at a real board and at its twin."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from hil.cli.boards.time_given import seconds_of
from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_view import ShownView, line
from hil.cli.framework.shown_words import counted


def parity(
    sessions: Annotated[
        list[str] | None,
        typer.Argument(
            help="As sac/identify; a board, for all of its; a file (*.json), or a folder of them."
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option("--at", help="The real board's port: a path, socket://... or rfc2217://..."),
    ] = None,
    baud: Annotated[
        int | None,
        typer.Option("--baud", min=50, max=4_000_000, help="Its baud. [default: the board's usual one]"),
    ] = None,
    profile: Annotated[
        str | None, typer.Option("--profile", help="The board. [default: what the sessions say]")
    ] = None,
    moves: Annotated[
        bool, typer.Option("--moves", help="Also type sessions that turn the shaft. Look that it is free.")
    ] = False,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record", help="Write the board's answers as sessions: a file, or a folder for several."
        ),
    ] = None,
    tolerance: Annotated[
        str, typer.Option("--tolerance", metavar="TIME", help="Maximum difference of times: 20ms, 500us.")
    ] = "20ms",
    show: Annotated[bool, typer.Option("--show", help="Show answers that part side by side.")] = False,
    lists: Annotated[bool, typer.Option("--list", help="List the sessions, and type nothing.")] = False,
    folders: Annotated[
        list[Path] | None,
        typer.Option("--folder", help="A folder with your own boards, as in profile_path."),
    ] = None,
) -> CommandAnswer:
    """Type sessions at a real board and at its twin, and score how far they are the same.

    Each command is compared: its bytes, the times of its first and last byte, and the end of its motion. The
    twin has just started, and has the factory's settings, unless the session says otherwise; it goes on
    simulated time. A session that may turn the shaft is left out without --moves. Exits with 1 if board and
    twin part, or the board stops answering.

    Example: hil parity sac/identify --at /dev/ttyUSB0
    """
    from hil.cli.parity.board_at_port import BoardAtPort
    from hil.cli.parity.parity_views import score_words, session_blocks, session_row
    from hil.cli.parity.session_choice import chosen_sessions

    own_folders = tuple(folder.resolve() for folder in folders or ())
    if lists:
        return _listed(sessions or [], profile, own_folders)
    tolerance_ms = seconds_of(tolerance, "--tolerance") * 1000
    chosen = chosen_sessions(sessions or [], profile, own_folders)
    if not chosen:
        raise fail(
            "SESSION is missing; name a session or a board; `hil parity --list` lists them", Exit.MISTAKE
        )
    left_out = [each.name for each in chosen if each.session.moves and not moves]
    chosen = [each for each in chosen if each.name not in left_out]
    if not chosen:
        raise fail(f"hil: {_turning(left_out)}: --moves types them too", Exit.MISTAKE)
    if at is None:
        raise fail("--at is missing; --at says where the board is, as in --at /dev/ttyUSB0", Exit.MISTAKE)
    board = BoardAtPort(chosen, own_folders, at, baud)
    played = board.play(tolerance_ms, record)
    below = list[str]()
    if left_out:
        below.append(f"Left out: {_turning(left_out)}: --moves types them too.")
    if unplayed := [each.name for each in chosen[len(played) :]]:
        below.append(f"Not typed any more: {', '.join(unplayed)}.")
    if len(played) > 1:
        below.append(f"All: {score_words(played)}.")
    blocks = (block for each in played for block in session_blocks(each, show))
    view = ShownView(*blocks, *(line(each, wraps=True) for each in below))
    is_equal = all(each.is_equal for each in played) and not unplayed
    answer = {
        "profile": board.profile,
        "at": at,
        "equal": is_equal,
        "sessions": [session_row(each) for each in played],
        "left_out": left_out,
        "not_typed": unplayed,
    }
    code = Exit.INTERRUPTED if board.is_interrupted else Exit.DONE if is_equal else Exit.FAILED
    return CommandAnswer(answer, view.text(), code)


def _turning(names: Sequence[str]) -> str:
    return f"{', '.join(names)} may turn the shaft"


def _listed(words: Sequence[str], profile: str | None, folders: Sequence[Path]) -> CommandAnswer:
    from hil.cli.parity.session_choice import chosen_sessions
    from hil.discovery.board_places import find_places
    from hil.discovery.board_sessions import shipped_sessions

    if not words and not profile:
        chosen = [
            each
            for board in dict.fromkeys(name.split("/")[0] for name in shipped_sessions(find_places(folders)))
            for each in chosen_sessions([board], None, folders)
        ]
    else:
        chosen = chosen_sessions(words, profile, folders)
    rows = [
        {
            "session": each.name,
            "profile": each.session.profile,
            "moves": each.session.moves,
            "commands": sum(not step.prepares for step in each.session.steps),
            "about": each.session.about,
            "file": str(each.file),
        }
        for each in chosen
    ]
    lines = [
        f"{row['session']}: {counted(int(str(row['commands'])), 'command')}"
        f"{', MAY TURN THE SHAFT' if row['moves'] else ''}. {row['about']}"
        for row in rows
    ]
    return CommandAnswer(rows, ShownView(*(line(each, wraps=True) for each in lines)).text())
