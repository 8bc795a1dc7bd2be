"""Twin's side of a session, in virtual time."""

from collections.abc import Iterator
from pathlib import Path

from hil.compose import find_catalogue
from hil.compose.replay import MemoryOptions
from hil.config import ConfigError
from hil.testing.bench import Bench
from hil.testing.parity.parity_scores import STOOD, StepScore, scored
from hil.testing.parity.step_player import StepPlayer
from hil.testing.parity.typed_session import StepAnswer, TypedSession, answers_in
from hil.vocab.dialogue import DialogueError
from hil.vocab.profile import Profile
from hil.vocab.recorded_session import Difference, SessionRefused

DEVICE = "d"
SETTLE_MS = 300.0
"""Silence after a start before the first command is typed."""


def twin_answers(session: TypedSession, folder: Path | None = None) -> list[StepAnswer]:
    """Type a session at a twin that has just started. ``folder``: of a board of the user's own.

    Raises:
        SessionRefused: there is no such twin.
        DialogueError: it has failed, or does not get ready.
    """
    paths = {"profile_path": [str(folder.resolve().parent)]} if folder else {}
    device = {"profile": session.profile, **session.board}
    try:
        bench = Bench({"bench": "parity", **paths, "devices": {DEVICE: device}})
    except ConfigError as error:
        raise SessionRefused(f"its board: {error}") from None
    with bench:
        if bench.start():
            raise DialogueError("the twin is not ready within half a minute")
        player = StepPlayer(session)
        bench.talk(DEVICE, player.settle(SETTLE_MS))
        bench.talk(DEVICE, player.play())
        if failed := bench.device(DEVICE).failed:
            raise DialogueError(f"the twin has stopped: {failed}")
    return player.answers


def recording_differences(
    name: str, session: TypedSession, folder: Path | None = None, tolerance_ms: float | None = None
) -> Iterator[Difference]:
    """Compare a recording with the twin.

    Raises:
        SessionRefused: it is no recording, or there is no such twin.
    """
    recorded = answers_in(session)
    try:
        twin = twin_answers(session, folder)
    except DialogueError as error:
        yield Difference(session=name, at_ms=None, where="the twin", expected=None, got=str(error))
        return
    within_ms = session.tolerance_ms if tolerance_ms is None else tolerance_ms
    profile = profile_of(session.profile, folder)
    for each in scored(session, recorded, twin, profile.is_own_words, within_ms, session.host_ms).steps:
        yield from _differences(name, each)


def _differences(name: str, each: StepScore) -> Iterator[Difference]:
    where = f"command {each.number}"
    if each.parting:
        at = f"{where}, byte {each.parting.at}"
        yield Difference(
            session=name, at_ms=None, where=at, expected=each.parting.board, got=each.parting.twin
        )
    for what, apart in each.late.items():
        times = (f"{apart.board_ms:.3f} ms", f"{apart.twin_ms:.3f} ms")
        yield Difference(session=name, at_ms=None, where=f"{where}, {what}", expected=times[0], got=times[1])
    if len(each.never_stood) == 1:
        ends = ["never" if side in each.never_stood else "in its time" for side in ("board", "twin")]
        yield Difference(session=name, at_ms=None, where=f"{where}, {STOOD}", expected=ends[0], got=ends[1])


def profile_of(name: str, folder: Path | None = None) -> Profile:
    """Profile of a board. Raises SessionRefused: there is none of this name."""
    boards = find_catalogue({"memory": MemoryOptions}, [folder.resolve().parent] if folder else ()).boards
    if name not in boards:
        raise SessionRefused(f"there is no board {name!r}")
    return boards[name]
