"""Sessions by steps: what is typed, how long its answer may take, and what a board has answered."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from hil.vocab.recorded_session import SessionRefused

LONGEST_MS = 600_000.0
TOLERANCE_MS = 20.0
"""Difference of times that a USB adapter (16 ms) and the host may make."""


def _latin_1(text: str) -> str:
    try:
        text.encode("latin-1")
    except UnicodeEncodeError:
        raise ValueError("one character is one byte: no character above \\u00ff") from None
    return text


Keys = Annotated[str, AfterValidator(_latin_1)]
_Ms = Annotated[float, Field(ge=0, le=10 * LONGEST_MS)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class MeasuredNumber(_Part):
    """Number that a board has measured, behind a text that does not change."""

    within: float = Field(ge=0)
    """Maximum difference between board and twin."""
    turn: float | None = Field(default=None, gt=0)
    """Value at which it begins again, as 360 of an angle."""
    from_first: bool = False
    """True if the change since the first one in the session counts, not the number: a shaft may stand
    anywhere."""


class StandStill(_Part):
    """Way of a board to tell that its motion has ended."""

    shows: Keys = Field(min_length=1)
    """Text that comes then."""
    types: Keys = ""
    """Question that it is the answer to; empty: it comes by itself."""
    every_ms: float = Field(default=50.0, ge=5, le=LONGEST_MS)
    """Interval of the questions."""
    within_ms: float = Field(gt=0, le=LONGEST_MS)
    """Maximum time since the step was typed."""


class TypedStep(_Part):
    """Step of a session, and in a recording the board's answer. Times are since it was typed."""

    types: Keys = Field(min_length=1)
    for_ms: float = Field(gt=0, le=LONGEST_MS)
    """Time for its answer."""
    prepares: bool = False
    """True if it only brings the board to a known state, and its answer is not compared."""
    stands: StandStill | None = None
    """Way to see the end of the motion that it starts."""
    answer: Keys | None = None
    first_ms: _Ms | None = None
    last_ms: _Ms | None = None
    stood_ms: _Ms | None = None


class TypedSession(_Part):
    """Session that is typed step by step, at a board that has been on for a while."""

    profile: str = Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")
    about: str = ""
    moves: bool
    """True if the shaft may turn."""
    recorded: str = ""
    """Origin of its answers."""
    board: Mapping[str, Any] = Field(default={})
    """Keys of the twin in a configuration, beside its profile."""
    measured: Mapping[Keys, MeasuredNumber] = Field(default={})
    """Numbers that are measurements, by the text before them; empty: at the beginning of a line."""
    ends_by: Keys = ""
    """Text that is typed when it is broken off, to stop the board."""
    host_ms: _Ms = 0.0
    """Time that host and adapter added to each answer of the recording."""
    tolerance_ms: _Ms = TOLERANCE_MS
    steps: Sequence[TypedStep] = Field(min_length=1)


@dataclass
class StepAnswer:
    """Answer of a board to a step; times in ms since it was typed, None: nothing came."""

    text: str = ""
    first_ms: float | None = None
    last_ms: float | None = None
    stood_ms: float | None = None
    """Time at which the board told that it stands; None: it did not, or the step does not ask."""


def typed_session(session: Mapping[str, Any]) -> TypedSession:
    """Read a session. Raises SessionRefused: with each mistake and its place."""
    try:
        return TypedSession.model_validate(session)
    except ValidationError as error:
        lines = [f"{_place(each['loc'])}: {_words(each)}" for each in error.errors(include_url=False)]
        raise SessionRefused("; ".join(lines)) from None


def _place(loc: tuple[int | str, ...]) -> str:
    if loc[:1] == ("steps",) and len(loc) > 1 and isinstance(loc[1], int):
        return ".".join([f"step {loc[1] + 1}", *map(str, loc[2:])])
    return ".".join(map(str, loc)) or "the session"


def _words(error: Any) -> str:
    words = {"missing": "this is missing", "extra_forbidden": "there is no such key"}
    return words.get(error["type"]) or error["msg"].removeprefix("Value error, ")


def recording_of(
    session: TypedSession, answers: Sequence[StepAnswer], recorded: str, host_ms: float, tolerance_ms: float
) -> TypedSession:
    """Session with the answers of a board; of one that was broken off the steps so far."""
    steps = [
        step.model_copy(
            update={
                "answer": answer.text,
                "first_ms": _rounded(answer.first_ms),
                "last_ms": _rounded(answer.last_ms),
                "stood_ms": _rounded(answer.stood_ms),
            }
        )
        for step, answer in zip(session.steps, answers, strict=False)
    ]
    told = {"recorded": recorded, "host_ms": round(host_ms, 3), "tolerance_ms": tolerance_ms}
    return session.model_copy(update={"steps": steps, **told})


def _rounded(value_ms: float | None) -> float | None:
    return None if value_ms is None else round(max(value_ms, 0.0), 3)


def answers_in(session: TypedSession) -> list[StepAnswer]:
    """Answers in a recording. Raises SessionRefused: a step has none."""
    for number, step in enumerate(session.steps, 1):
        if step.answer is None:
            raise SessionRefused(f"step {number}: it has no answer: this is no recording")
    return [
        StepAnswer(step.answer or "", step.first_ms, step.last_ms, step.stood_ms) for step in session.steps
    ]


def as_text(session: TypedSession) -> str:
    """Text of a session's file, a step a line."""
    data = session.model_dump(mode="json", exclude_defaults=True)
    steps = ",\n".join("    " + json.dumps(step) for step in data.pop("steps"))
    head = "".join(f"  {json.dumps(key)}: {json.dumps(value)},\n" for key, value in data.items())
    return f'{{\n{head}  "steps": [\n{steps}\n  ]\n}}\n'
