"""Typing of a session's steps, as a dialogue: the same at a board and at its twin."""

from collections.abc import Generator, Sequence
from typing import Any

from hil.testing.parity.typed_session import StandStill, StepAnswer, TypedSession, TypedStep
from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Progress, Send, Step
from hil.vocab.shown_text import printable
from hil.vocab.time import NS_PER_MS

QUIET_MS, LATE_MS = 30.0, 1000.0
"""Silence that ends an answer, and maximum time after the step's own that is waited for it."""
_ASKED_MS = 500.0
"""Maximum time for the answer to a question whether it stands."""
_SLICE_MS = 250.0
"""Longest wait in one piece: Ctrl-C is noticed between two."""
_SHOWN = 40
_SILENT = 2
"""Number of answers in a row that may be missing before a board is taken as lost."""


class NotThisBoard(DialogueError):
    """Error of a port whose answers are those of no such board, as at the wrong baud."""


class StepPlayer:
    """Player of a session. ``answers`` has those so far, also when the dialogue was broken off.

    ``expected``: the twin's answers; None: this is the twin. A board that leaves two of them out in a row, or
    whose first has nothing of the twin's, gets no more. ``name``: of the session, for reports of progress;
    empty: there are none.
    """

    def __init__(
        self, session: TypedSession, expected: Sequence[StepAnswer] | None = None, name: str = ""
    ) -> None:
        self.answers: list[StepAnswer] = []
        self.whole = 0
        """Number of answers that are whole."""
        self._session, self._expected = session, expected
        self._name = name

    def settle(self, ready_ms: float) -> Dialogue[None]:
        """Wait until a board that started when its port was opened is ready, and says no more."""
        heard: Heard = yield Listen(0)
        yield from self._listened(StepAnswer(), heard.at_ns, ready_ms)

    def play(self) -> Dialogue[None]:
        """Type the steps.

        Raises:
            DialogueError: the port has gone, or the board has stopped answering.
            NotThisBoard: it answers as no such board does.
        """
        steps = self._session.steps
        for number, step in enumerate(steps, 1):
            if self._name:
                yield Progress(number, len(steps), f"{self._name}, step {number}")
            yield from self._step(step)
            self.whole = number
            if self._expected is not None:
                self._look_at_answers(self._expected)

    def _step(self, step: TypedStep) -> Dialogue[None]:
        heard: Heard = yield Listen(0)
        answer, sent_ns = StepAnswer(), heard.at_ns
        self.answers.append(answer)
        _add(answer, heard, sent_ns)
        yield Send(step.types.encode("latin-1"))
        if step.stands and not step.stands.types:
            yield from self._shown(step.stands, answer, sent_ns)
        yield from self._listened(answer, sent_ns, step.for_ms)
        if step.stands and step.stands.types:
            yield from self._asked(step.stands, answer, sent_ns)

    def _listened(self, answer: StepAnswer, sent_ns: int, for_ms: float) -> Dialogue[None]:
        """Collect what comes for so long, and then until nothing more comes."""
        end_ns = sent_ns + _ns(for_ms)
        last_ns = end_ns + _ns(LATE_MS)
        heard: Heard = yield Listen(0)
        while heard.at_ns < end_ns or (heard.data and heard.at_ns < last_ns):
            _add(answer, heard, sent_ns)
            heard = yield Listen(min(max(end_ns - heard.at_ns, _ns(QUIET_MS)), _ns(_SLICE_MS)))
        _add(answer, heard, sent_ns)

    def _shown(self, stands: StandStill, answer: StepAnswer, sent_ns: int) -> Dialogue[None]:
        """Collect what comes until the board tells by itself that it stands."""
        now_ns, end_ns = sent_ns, sent_ns + _ns(stands.within_ms)
        while stands.shows not in answer.text and now_ns < end_ns:
            heard: Heard = yield Listen(min(end_ns - now_ns, _ns(_SLICE_MS)))
            now_ns = heard.at_ns
            _add(answer, heard, sent_ns)
        if stands.shows in answer.text:
            answer.stood_ms = answer.last_ms

    def _asked(self, stands: StandStill, answer: StepAnswer, sent_ns: int) -> Dialogue[None]:
        """Ask until the board says that it stands: the time of that question counts."""
        end_ns, shows = sent_ns + _ns(stands.within_ms), stands.shows.encode("latin-1")
        every_ns = _ns(stands.every_ms)
        heard: Heard = yield Listen(0)
        while heard.at_ns < end_ns:
            asked_ns = heard.at_ns
            yield Send(stands.types.encode("latin-1"))
            said = yield from self._said_to(shows, asked_ns)
            heard = yield Listen(0)
            if shows in said:
                answer.stood_ms = (asked_ns - sent_ns) / NS_PER_MS
                return
            while heard.at_ns < asked_ns + every_ns:
                heard = yield Listen(asked_ns + every_ns - heard.at_ns)

    def _said_to(self, shows: bytes, asked_ns: int) -> Generator[Step, Any, bytes]:
        """Answer to a question, to its end: a silence."""
        said, is_begun = b"", False
        now_ns = asked_ns
        while now_ns < asked_ns + _ns(_ASKED_MS):
            heard: Heard = yield Listen(_ns(QUIET_MS if is_begun else _ASKED_MS))
            now_ns = heard.at_ns
            if not heard.data:
                break
            said, is_begun = said + heard.data, True
        return said

    def _look_at_answers(self, expected: Sequence[StepAnswer]) -> None:
        typed = zip(self._session.steps, expected, self.answers, strict=False)
        answered = [(step, twin.text, own.text) for step, twin, own in typed if twin.text]
        if not answered or not expected[len(self.answers) - 1].text:
            return
        last = answered[-_SILENT:]
        if len(last) == _SILENT and not any(own for _, _, own in last):
            if not any(own for _, _, own in answered):
                raise DialogueError("nothing answers: is it on, is this its terminal, is the baud right?")
            keys = " and ".join(f'"{printable(step.types)}"' for step, _, _ in last)
            raise DialogueError(f"the board has stopped answering: nothing came of {keys}")
        _, twin, own = answered[0]
        if len(answered) == 1 and own and not _has_any(twin, own):  # nothing more: it may move by any word
            heard = own[:_SHOWN]
            raise NotThisBoard(
                f'"{printable(heard)}" is no answer of a {self._session.profile}: another board, or another'
                " baud?"
            )


def _ns(duration_ms: float) -> int:
    return round(duration_ms * NS_PER_MS)


def _add(answer: StepAnswer, heard: Heard, sent_ns: int) -> None:
    if heard.data:
        at_ms = (heard.at_ns - sent_ns) / NS_PER_MS
        answer.text += heard.data.decode("latin-1")
        answer.first_ms = at_ms if answer.first_ms is None else answer.first_ms
        answer.last_ms = at_ms


def _has_any(twin: str, own: str) -> bool:
    """True if an answer has a word of the twin's, of two characters or more, or a shorter answer whole."""
    words = [word for word in twin.split() if len(word) > 1] or [twin]
    return any(word in own for word in words)
