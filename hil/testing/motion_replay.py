"""Replays of recorded motions of Walter's joints: step generator by its calls, drive law by its samples.

A case is a row of ``INDEX.json``: with a ``joint`` it is of the law, else of the step generator alone. Its
looks for pulses are ``poll_us`` apart; the index's ``poll_us`` stands for cases without. Its calls are in
``NAME_ops.csv``, or rows ``[t_us, op, value]`` under ``ops``; without both they are those of the case that
its name begins with. Where a table has ``joint_deg_true``, the joint is there, and not where its pulses
would have brought it: something has blocked or moved it. Steps that were not recorded are not compared.
"""

import csv
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from struct import pack
from typing import Any

from hil.core._native import JointReplay
from hil.vocab.recorded_session import Difference, SessionRefused

INDEX = "INDEX.json"
START_MS = 1000
"""Clock at which the recordings of the law begin."""
SAMPLE_US = 20_000
_OPERATIONS = {"S": 0, "A": 1, "T": 2}
_STATE = {
    "currentPos": "position",
    "targetPos": "target",
    "n": "n",
    "stepInterval_us": "interval_us",
    "direction": "dir",
    "speed_hex": "speed",
    "acceleration_hex": "acceleration",
    "c0_hex": "c0",
    "cn_hex": "cn",
    "cmin_hex": "cmin",
}
"""Numbers of the step generator by their columns."""
_OF_LAW = {"measured_hex": "measured_deg", "toBe_hex": "to_be_deg", "integral_hex": "integral"}
_GENERATOR = {
    "gear": 1.0,
    "micro": 1,
    "start_deg": 0.0,
    "min": 0.0,
    "max": 0.0,
    "kP": 0.0,
    "maxSpeed": 1,
    "maxAcc": 1,
}
_COMMANDS = "commands_setAngle_tms_deg_durms"
_TRUE_DEG = "joint_deg_true"
_ROUNDED_DEG = 1e-6
"""Most that a table's angle differs by rounding: it has six decimals."""
_POLL_US = 10
_ENDS = ("_ops", "_samples", "_steps")
Row = Mapping[str, str]
Step = tuple[int, int]


@dataclass(frozen=True)
class MotionCase:
    """Recorded motion: a row of ``INDEX.json`` and its two tables."""

    name: str
    about: Mapping[str, Any]
    joint: Mapping[str, Any]
    """Configuration of its joint; empty: the step generator alone."""
    rows: Sequence[Row]
    """Calls or samples, with the state right after each where it was recorded."""
    steps: Sequence[Step] | None
    """Times in us, and directions; None: they were not recorded."""
    poll_us: int


def replay_motion(path: str | Path) -> list[Difference]:
    """Replay a recorded motion, and compare each number and each step; answers the differences.

    ``path``: one of the case's files, or their common beginning, or a folder with several; ``INDEX.json`` is
    there, or in the folder above, and says what the cases are.

    Raises:
        SessionRefused: this is no recorded motion.
        OSError: a file cannot be read.
    """
    path = Path(path)
    index, folder = _index_of(path)
    known = {str(case["name"]): case for case in index["cases"]}
    if path.is_dir() or path.name == INDEX:
        names = list(known)
    else:
        stem = path.stem if path.suffix == ".csv" else path.name
        names = [next((stem.removesuffix(end) for end in _ENDS if stem.endswith(end)), stem)]
    found: list[Difference] = []
    for name in names:
        if name not in known:
            raise SessionRefused(
                f"{path}: there is no case {name!r} in {INDEX}; there are: {', '.join(known)}"
            )
        found += _compared(_read_case(name, known[name], index, folder))
    return found


def _index_of(path: Path) -> tuple[Mapping[str, Any], Path]:
    """Motions of the index that is nearest, and the folder with the tables."""
    here = path if path.is_dir() else path.parent
    for folder in (here, here.parent):
        if (file := folder / INDEX).is_file():
            index = json.loads(file.read_text("utf-8-sig"))
            motions = index.get("motion") if isinstance(index, dict) else None
            if not isinstance(motions, dict) or "cases" not in motions:
                raise SessionRefused(f"{file}: it says nothing of motions")
            return motions, here if here != folder or not (folder / "motion").is_dir() else folder / "motion"
    raise SessionRefused(f"{path}: there is no {INDEX} beside it or above")


def _read_case(name: str, about: Mapping[str, Any], index: Mapping[str, Any], folder: Path) -> MotionCase:
    poll_us = about.get("poll_us", index.get("poll_us", _POLL_US))
    if not isinstance(poll_us, int) or isinstance(poll_us, bool) or poll_us < 1:
        raise SessionRefused(f"{name}: poll_us is {poll_us!r}; write a whole number of us, 1 or more")
    table = _table(folder / f"{name}_steps.csv")
    steps = None if table is None else [(int(row["t_us"]), int(row["dir"])) for row in table]
    if "joint" in about:
        joint = dict(index["joint_config"][about["joint"]]) | {"start_deg": about["start_deg"]}
        samples = _table(folder / f"{name}_samples.csv")
        if samples is None:
            raise SessionRefused(
                f"{name}: there is no {name}_samples.csv, which says when samples were taken"
            )
        return MotionCase(name, about, joint, samples, steps, poll_us)
    return MotionCase(name, about, {}, _calls(name, about, index, folder), steps, poll_us)


def _calls(name: str, about: Mapping[str, Any], index: Mapping[str, Any], folder: Path) -> list[Row]:
    """Calls of a case of the step generator, its own or those of the case that its name begins with; these
    without states."""
    if (own := _table(folder / f"{name}_ops.csv")) is not None:
        return own
    if "ops" in about:
        return [{"t_us": str(t_us), "op": op, "value": str(value)} for t_us, op, value in about["ops"]]
    for other in sorted((str(case["name"]) for case in index["cases"]), key=len, reverse=True):
        if name.startswith(f"{other}_") and (calls := _table(folder / f"{other}_ops.csv")) is not None:
            return [{key: row[key] for key in ("t_us", "op", "value")} for row in calls]
    raise SessionRefused(
        f"{name}: nothing says what was called: there is no {name}_ops.csv, {INDEX} has no ops of it, and "
        "its name does not begin with that of a case with calls"
    )


def _table(file: Path) -> list[Row] | None:
    """Rows of a table; None: there is no such file."""
    if not file.is_file():
        return None
    with file.open(newline="", encoding="utf-8-sig") as text:
        return list(csv.DictReader(text))


def _compared(case: MotionCase) -> Iterator[Difference]:
    if case.steps is None and not any({*_STATE, *_OF_LAW} & row.keys() for row in case.rows):
        raise SessionRefused(f"{case.name}: nothing to compare: no {case.name}_steps.csv, and no states")
    states, steps = _law(case) if case.joint else _generator(case)
    for row, state in zip(case.rows, states, strict=True):
        for column, value in state.items():
            if column in row and row[column] != value:
                yield Difference(
                    session=case.name,
                    at_ms=int(row["t_us"]) / 1000,
                    where=column,
                    expected=row[column],
                    got=value,
                )
    for place in range(max(len(steps), len(case.steps)) if case.steps is not None else 0):
        assert case.steps is not None
        wanted = case.steps[place] if place < len(case.steps) else None
        got = steps[place] if place < len(steps) else None
        if wanted != got:
            at = wanted or got
            assert at
            shown = [each and f"{each[0]} us, {each[1]:+d}" for each in (wanted, got)]
            where = f"step {place + 1}"
            yield Difference(
                session=case.name, at_ms=at[0] / 1000, where=where, expected=shown[0], got=shown[1]
            )
            return  # what follows is another motion


def _state(replay: JointReplay, columns: Mapping[str, str]) -> dict[str, str]:
    row: Mapping[str, Any] = {**replay.row()}
    return {
        column: pack(">f", row[name]).hex() if column.endswith("_hex") else str(row[name])
        for column, name in columns.items()
    }


def _generator(case: MotionCase) -> tuple[list[dict[str, str]], list[Step]]:
    """Step generator alone, by calls; at one time a call comes before the poll."""
    replay, at_us = JointReplay(_GENERATOR, 0, case.poll_us), 0
    states: list[dict[str, str]] = []
    steps: list[Step] = []
    for row in case.rows:
        until_us = int(row["t_us"])
        steps += replay.steps(at_us, until_us)
        at_us = until_us
        replay.set(_OPERATIONS[row["op"]], float(row["value"]))
        states.append(_state(replay, _STATE))
    end_us = round(case.about["end_ms"] * 1000) if "end_ms" in case.about else _last_us(case)
    return states, steps + replay.steps(at_us, end_us + 1)


def _last_us(case: MotionCase) -> int:
    """Time of the last thing that was recorded."""
    return max(int(case.rows[-1]["t_us"]) if case.rows else 0, case.steps[-1][0] if case.steps else 0)


def _law(case: MotionCase) -> tuple[list[dict[str, str]], list[Step]]:
    """Law and step generator of one joint with an ideal encoder; a command comes before the sample of its
    time, and that before the poll."""
    replay = JointReplay(dict(case.joint), START_MS * 1000, case.poll_us)
    replay.set_up()
    replay.sample(case.joint["start_deg"], START_MS)
    replay.move(case.joint["start_deg"], START_MS, 1)
    commands = [
        (START_MS * 1000 + round(t_ms * 1000), deg, duration_ms)
        for t_ms, deg, duration_ms in case.about.get(_COMMANDS, ())
    ]
    at_us, states = START_MS * 1000, list[dict[str, str]]()
    stood = ("", replay.deg)
    steps: list[Step] = []
    for row in case.rows:
        sample_us = int(row["t_us"])
        while commands and commands[0][0] <= sample_us:
            command_us, deg, duration_ms = commands.pop(0)
            steps += replay.steps(at_us, command_us)
            at_us = command_us
            replay.move(deg, command_us // 1000, duration_ms)
        steps += replay.steps(at_us, sample_us)
        at_us = sample_us
        stood = _place(replay, row, stood)
        replay.sample(math.nan, sample_us // 1000)
        states.append(_state(replay, _OF_LAW | _STATE))
    # The recording ends within a sample of the last one: what it does not have any more is no difference.
    end_us = _last_us(case)
    return states, steps + [step for step in replay.steps(at_us, at_us + SAMPLE_US) if step[0] <= end_us]


def _place(replay: JointReplay, row: Row, stood: tuple[str, float]) -> tuple[str, float]:
    """Place the joint where it was recorded, if its pulses have not brought it there; answers where it is
    now, as recorded and exactly. ``stood``: the same of the sample before, with the exact angle of one that
    has not moved."""
    told = row.get(_TRUE_DEG) or ""
    if told and abs(float(told) - replay.deg) > _ROUNDED_DEG:
        replay.place(stood[1] if told == stood[0] else float(told))
    return told, replay.deg
