"""Player of recorded sessions: ``play`` sends what was sent, and compares what comes back."""

import json
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import zip_longest
from pathlib import Path
from typing import Any

from hil.compose import find_catalogue
from hil.compose.replay import MemoryOptions
from hil.testing.bench import Bench
from hil.vocab.recorded_session import Difference, Digest, SessionPlan, SessionRefused, TimedText

DEVICE = "d"
_MS = 1e6
_UNREADABLE = "no board reads such a session"


def play(
    path: str | Path,
    *,
    profile: str | None = None,
    folder: str | Path | None = None,
    tolerance_ms: float | None = None,
) -> list[Difference]:
    """Play a session's file against a twin, or each ``*.json`` of a folder; answers the differences.

    ``profile``: board that it is of; None: the first that reads it. ``folder``: folder of a board of your
    own. ``tolerance_ms``: between the times of a recording and its twin; None: the board's.

    Raises:
        SessionRefused: the file is no session, or of no board that there is.
        OSError: it cannot be read.
    """
    files = session_files(path)
    boards = find_catalogue(
        {"memory": MemoryOptions}, [Path(folder).resolve().parent] if folder else ()
    ).boards
    found: list[Difference] = []
    for file in files:
        names = [profile] if profile else sorted(boards)
        found += _play_file(file, names, boards, Path(folder) if folder else None, tolerance_ms)
    return found


def session_files(path: str | Path) -> list[Path]:
    """Sessions' files of a folder, or the one file. Raises SessionRefused: the folder has none."""
    path = Path(path)
    files = sorted(path.glob("*.json")) if path.is_dir() else [path]
    if not files:
        raise SessionRefused(f"{path}: there is no session in it (*.json)")
    return files


def _play_file(
    file: Path,
    names: Sequence[str],
    boards: Mapping[str, Any],
    folder: Path | None,
    tolerance_ms: float | None,
) -> list[Difference]:
    try:
        session = json.loads(file.read_text("utf-8-sig"))
    except ValueError as error:
        raise SessionRefused(f"{file}: this is not JSON in UTF-8 ({error})") from None
    if not isinstance(session, dict):
        raise SessionRefused(f"{file}: a session is a JSON object")
    if "steps" in session:
        return _play_steps(file, session, names, folder, tolerance_ms)
    for name in names:
        if name not in boards:
            raise SessionRefused(f"there is no board {name!r}")
        read = boards[name].session
        try:
            plan = read(session) if read else None
        except SessionRefused as error:
            raise SessionRefused(f"{file}: {error}") from None
        except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
            raise SessionRefused(f"{file}: it is no session of a {name}: {error!r}") from None
        if plan is not None:
            return list(play_plan(file.stem, plan, tolerance_ms))
    raise SessionRefused(f"{file}: {_UNREADABLE}")


def _play_steps(
    file: Path, session: Any, names: Sequence[str], folder: Path | None, tolerance_ms: float | None
) -> list[Difference]:
    """Play a session by steps, as ``hil parity`` records them."""
    from hil.testing.parity.twin_player import recording_differences
    from hil.testing.parity.typed_session import typed_session

    try:
        steps = typed_session(session)
        if steps.profile not in names:
            raise SessionRefused(f"it is a session of a {steps.profile}, no {' or '.join(names)}")
        return list(recording_differences(file.stem, steps, folder, tolerance_ms))
    except SessionRefused as error:
        raise SessionRefused(f"{file}: {error}") from None


def play_plan(name: str, plan: SessionPlan, tolerance_ms: float | None = None) -> Iterator[Difference]:
    """Play a session that a board has read; answers the differences."""
    faults = [{**each} for each in plan.faults]
    config = {"bench": "session", "devices": {DEVICE: dict(plan.device)}, "faults": faults}
    with Bench(config) as bench:
        uarts = {uart: bench.port(DEVICE, uart) for uart in {*plan.timelines, *plan.texts, *plan.digests}}
        if plan.encoder:
            points, is_linear = plan.encoder
            bench.axis(DEVICE).script_encoder(points, "linear" if is_linear else "hold")
        for t_ms, text in plan.inputs:
            bench.run_until(ms=t_ms)
            bench.port(DEVICE).write(text.encode("latin-1"))
        bench.run_until(ms=plan.end_ms)
        if failed := bench.device(DEVICE).failed:
            yield Difference(session=name, at_ms=None, where="the twin", expected=None, got=failed)
        heard = {uart: _joined(face.read_timed()) for uart, face in uarts.items()}
    most_ms = plan.tolerance_ms if tolerance_ms is None else tolerance_ms
    for uart, wanted in plan.timelines.items():
        got = [each for each in heard[uart] if each[0] >= plan.from_ms]
        yield from _timed(name, uart or "command port", wanted, got, most_ms, plan)
    for uart, text in plan.texts.items():
        said = "".join(text for at_ms, text in heard[uart] if at_ms >= plan.texts_from_ms)
        yield from _untimed(name, uart, text, said, plan)
    for uart, digest in plan.digests.items():
        said = "".join(text for at_ms, text in heard[uart] if at_ms >= plan.from_ms)
        yield from _digested(name, uart or "command port", digest, said, plan)


def _digested(session: str, where: str, wanted: Digest, got: str, plan: SessionPlan) -> Iterator[Difference]:
    """Compare a long text with a digest, or with its head and tail where it has words of our own."""
    if any(plan.is_own_words(line) for line in got.split("\r\n")):
        heads = wanted.head.split("\r\n")[:-1], got.split("\r\n")
        tails = wanted.tail.split("\r\n")[1:], got.split("\r\n")
        head, tail = "\n".join(heads[0]), "\n".join(tails[0])
        yield from _untimed(session, f"{where}, head", head, "\n".join(heads[1][: len(heads[0])]), plan)
        own_tail = tails[1][len(tails[1]) - len(tails[0]) :]
        yield from _untimed(session, f"{where}, tail", tail, "\n".join(own_tail), plan)
        return
    shown = [
        f"{size} bytes, SHA-256 {digest}"
        for size, digest in (
            (wanted.size_bytes, wanted.sha256),
            (len(got), sha256(got.encode("latin-1")).hexdigest()),
        )
    ]
    if shown[0] != shown[1]:
        yield Difference(session=session, at_ms=None, where=where, expected=shown[0], got=shown[1])


def _joined(heard: Sequence[tuple[int, bytes]]) -> list[TimedText]:
    return [(at_ns / _MS, data.decode("latin-1")) for at_ns, data in heard]


def _timed(
    session: str,
    where: str,
    wanted: Sequence[TimedText],
    got: Sequence[TimedText],
    most_ms: float,
    plan: SessionPlan,
) -> Iterator[Difference]:
    """Compare two timelines, text by text."""
    for expected, heard in zip_longest(_texts(wanted), _texts(got)):
        (t_ms, text), (at_ms, said) = expected or (None, None), heard or (None, None)
        if text is None or said is None or not _is_same(text, said, plan):
            at = t_ms if t_ms is not None else at_ms
            yield Difference(session=session, at_ms=at, where=where, expected=text, got=said)
        elif t_ms is not None and at_ms is not None and abs(t_ms - at_ms) > most_ms + 1e-9:
            times = f"{text!r} at {t_ms:.6f} ms", f"{said!r} at {at_ms:.6f} ms"
            yield Difference(
                session=session, at_ms=t_ms, where=f"{where}, time", expected=times[0], got=times[1]
            )


def _texts(timeline: Sequence[TimedText]) -> list[TimedText]:
    joined: list[TimedText] = []
    for at_ms, text in timeline:
        if joined and abs(joined[-1][0] - at_ms) < 1e-7:
            joined[-1] = (joined[-1][0], joined[-1][1] + text)
        elif text:
            joined.append((at_ms, text))
    return joined


def _untimed(session: str, where: str, wanted: str, got: str, plan: SessionPlan) -> Iterator[Difference]:
    lines = zip_longest(wanted.split("\n"), got.split("\n"))
    for number, (expected, said) in enumerate(lines, 1):
        if expected != said and not (
            said is not None and expected is not None and plan.is_own_words(said.rstrip("\r"))
        ):
            yield Difference(
                session=session, at_ms=None, where=f"{where}, line {number}", expected=expected, got=said
            )


def _is_same(wanted: str, got: str, plan: SessionPlan) -> bool:
    if wanted == got:
        return True
    lines, own = wanted.split("\r\n"), got.split("\r\n")
    return len(lines) == len(own) and all(
        a == b or plan.is_own_words(b) for a, b in zip(lines, own, strict=True)
    )
