"""Real board at a port, at which sessions are typed, and its twin, at which they are typed first."""

import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

from hil import __version__
from hil.cli.framework.ask import fail
from hil.cli.framework.board_commands import Interrupted, SerialTalk
from hil.cli.framework.exit_codes import Exit
from hil.cli.parity.board_port import is_url, opening_words, refuse_port
from hil.cli.parity.parity_views import PlayedSession
from hil.cli.parity.session_choice import ChosenSession
from hil.compose import find_catalogue
from hil.host.new_file import write_file
from hil.testing.parity.parity_scores import SessionScore, scored
from hil.testing.parity.step_player import StepPlayer
from hil.testing.parity.twin_player import SETTLE_MS, twin_answers
from hil.testing.parity.typed_session import StepAnswer, TypedSession, as_text, recording_of
from hil.vocab.dialogue import Dialogue, DialogueError, Listen, Send
from hil.vocab.recorded_session import SessionRefused
from hil.vocab.time import NS_PER_S

USUAL_BAUD = 115200


class BoardAtPort:
    """Board at a port, for these sessions, which are all of its kind. Ends the command if hil has no such
    board."""

    def __init__(
        self, chosen: Sequence[ChosenSession], folders: Sequence[Path], at: str, baud: int | None
    ) -> None:
        self.profile = chosen[0].session.profile
        self.is_interrupted = False
        self._chosen, self._at = chosen, at
        catalogue = find_catalogue(path=folders)
        if problems := catalogue.problems(self.profile):
            raise fail("\n".join(map(str, problems)), Exit.MISTAKE)
        if self.profile not in catalogue.profiles:
            raise fail(f"hil: {chosen[0].name}: there is no board {self.profile!r}", Exit.MISTAKE)
        self._info = catalogue.profiles[self.profile]
        if not self._info.uarts:
            raise fail(f"hil: a {self.profile} has no serial port", Exit.MISTAKE)
        self._is_own_words = catalogue.boards[self.profile].is_own_words
        self._folder = next((each / self.profile for each in folders if (each / self.profile).is_dir()), None)
        self._baud = baud or self._info.baud() or USUAL_BAUD

    def play(self, tolerance_ms: float, record: Path | None) -> list[PlayedSession]:
        """Type the sessions, and write the recordings; the first that is broken off is the last. Ends the
        command before anything is sent if something is wrong."""
        files = _files(self._chosen, record)
        refuse_port(self._at)
        twins = [self._twin(each) for each in self._chosen]
        played: list[PlayedSession] = []
        try:
            with SerialTalk(
                self._at, self._baud, sets_dtr=self._info.usb == "native", is_alone=not is_url(self._at)
            ) as talk:
                for chosen, twin, file in zip(self._chosen, twins, files, strict=True):
                    name = chosen.name if sys.stderr.isatty() else ""
                    player = StepPlayer(chosen.session, twin, name)
                    broken = self._broken(talk, chosen.session, player, is_first=not played)
                    score = scored(chosen.session, player.answers, twin, self._is_own_words, tolerance_ms)
                    whole = player.answers[: player.whole]
                    recording = file and self._written(file, chosen.session, whole, score, tolerance_ms)
                    played.append(
                        PlayedSession(
                            name=chosen.name,
                            session=chosen.session,
                            score=score,
                            broken=broken,
                            recording=recording,
                        )
                    )
                    if broken:
                        break
        except DialogueError as error:
            raise fail(f"hil: {opening_words(self._at, str(error))}", Exit.MISTAKE) from None
        return played

    def _twin(self, chosen: ChosenSession) -> list[StepAnswer]:
        try:
            return twin_answers(chosen.session, self._folder)
        except (DialogueError, SessionRefused) as error:
            raise fail(f"hil: {chosen.name}: {error}", Exit.MISTAKE) from None

    def _broken(self, talk: SerialTalk, session: TypedSession, player: StepPlayer, *, is_first: bool) -> str:
        """Type a session; answers why it was broken off, if it was."""
        try:
            if is_first:  # opening a port starts some boards, and a SAC must hear nothing in its first second
                talk.run(player.settle(self._info.ready_after_s * 1000 + SETTLE_MS))
            talk.run(player.play())
            return ""
        except Interrupted as error:
            self.is_interrupted = True
            broken = str(error)
        except DialogueError as error:
            broken = str(error)
        if session.ends_by and player.answers:
            with suppress(DialogueError, Interrupted):
                talk.run(_typed(session.ends_by))
        return broken

    def _written(
        self,
        file: Path,
        session: TypedSession,
        answers: Sequence[StepAnswer],
        score: SessionScore,
        tolerance_ms: float,
    ) -> Path | None:
        """Write a recording; None: nothing is whole of it."""
        if not answers:
            return None
        day = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
        recorded = f"the board at {self._at}, {self._baud} baud, {day}, hil {__version__}"
        text = as_text(recording_of(session, answers, recorded, score.host_ms, tolerance_ms))
        try:
            write_file(file, text.encode())
        except OSError as error:
            raise fail(f"hil: {file}: {error.strerror}") from None
        return file


def _typed(text: str) -> Dialogue[None]:
    yield Send(text.encode("latin-1"))
    yield Listen(NS_PER_S // 2)


def _files(chosen: Sequence[ChosenSession], record: Path | None) -> list[Path | None]:
    """Files for the recordings; None: none is wanted. Makes their folder. Ends the command if one cannot be
    written, or would take the place of a session that is typed."""
    if record is None:
        return [None] * len(chosen)
    files = [record]
    if len(chosen) > 1 or record.is_dir() or not record.suffix:
        files = [record / f"{each.file.stem}.json" for each in chosen]
    if twice := [file for file, count in Counter(files).items() if count > 1]:
        raise fail(f"hil: --record: two sessions would be {twice[0]}", Exit.MISTAKE)
    for file in files:
        if file.resolve() in [each.file.resolve() for each in chosen]:
            raise fail(f"hil: --record {record}: {file} is the session itself", Exit.MISTAKE)
    try:
        files[0].parent.mkdir(parents=True, exist_ok=True)
        probe = files[0].with_name(f".{files[0].name}.probe")
        write_file(probe, b"")
        probe.unlink()
    except OSError as error:
        raise fail(f"hil: --record {record}: {error.strerror}", Exit.MISTAKE) from None
    return [*files]
