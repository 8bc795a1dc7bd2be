"""Sessions that are meant by a command line: by the names of those that boards have, or by files."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.discovery.board_places import find_places
from hil.discovery.board_sessions import shipped_sessions
from hil.testing.parity.typed_session import TypedSession, typed_session
from hil.vocab.near_words import meant
from hil.vocab.recorded_session import SessionRefused


@dataclass(frozen=True)
class ChosenSession:
    """Session by its name: of a shipped one its board's and its own, else the file's."""

    name: str
    session: TypedSession
    file: Path


def chosen_sessions(
    words: Sequence[str], profile: str | None, folders: Sequence[Path]
) -> list[ChosenSession]:
    """Find the sessions that are meant, each once; without words those of ``profile``. Ends the command if a
    word means none, or if they are of several boards."""
    places = find_places(folders)
    shipped = shipped_sessions(places)
    if profile and profile not in places.places:
        raise fail(f"hil: no board {profile!r}; {meant(profile, list(places.places))}", Exit.MISTAKE)
    found: dict[Path, ChosenSession] = {}
    for word in words or ([profile] if profile else []):
        for name, file in _files(word, profile, shipped, places.places):
            found.setdefault(file.resolve(), ChosenSession(name, _read(file), file))
    chosen = list(found.values())
    wanted = profile or (chosen[0].session.profile if chosen else "")
    for each in chosen:
        if each.session.profile != wanted:
            also = "--profile says" if profile else f"{chosen[0].name} one of a"
            raise fail(
                f"hil: {each.name} is a session of a {each.session.profile}, and {also} {wanted}: one board"
                " is at the port; nothing was sent",
                Exit.MISTAKE,
            )
    return chosen


def _files(
    word: str, profile: str | None, shipped: Mapping[str, Path], boards: Iterable[str]
) -> list[tuple[str, Path]]:
    """Names and files that a word means: a shipped session, a board's, a file, or those of a folder."""
    if word in shipped:
        return [(word, shipped[word])]
    if profile and f"{profile}/{word}" in shipped:
        return [(f"{profile}/{word}", shipped[f"{profile}/{word}"])]
    if word in boards:
        if of_board := [(name, file) for name, file in shipped.items() if name.startswith(f"{word}/")]:
            return of_board
        raise fail(f"hil: {word} has no sessions; there are {', '.join(shipped)}", Exit.MISTAKE)
    path = Path(word)
    if path.is_dir():
        if files := sorted(path.glob("*.json")):
            return [(str(file), file) for file in files]
        raise fail(f"hil: {word}: there is no session in it (*.json)", Exit.MISTAKE)
    if path.exists() or path.suffix == ".json":
        return [(word, path)]
    raise fail(f"hil: no session {word!r}; {meant(word, list(shipped))}", Exit.MISTAKE)


def _read(file: Path) -> TypedSession:
    try:
        session = json.loads(file.read_text("utf-8-sig"))
        if not isinstance(session, dict):
            raise SessionRefused("a session is a JSON object")
        if "steps" not in session:
            raise SessionRefused(
                "it has no steps: a session from a board's power-up on is played by"
                " `hil profile check --sessions`, at a twin alone"
            )
        return typed_session(session)
    except SessionRefused as error:
        raise fail(f"hil: {file}: {error}", Exit.MISTAKE) from None
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", Exit.MISTAKE) from None
    except ValueError as error:
        raise fail(f"hil: {file}: this is not JSON in UTF-8 ({error})", Exit.MISTAKE) from None
