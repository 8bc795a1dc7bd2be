"""Results of tests at seeds, one line each, in files too: of one shard, or of all."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, TextIO

from hil import __version__
from hil.testing.seeds.seed_options import Shard

FORMAT = "hil seeds 1"
"""First words of a file of results."""
PASSED, FAILED, SKIPPED = "passed", "failed", "skipped"


class ResultsRefused(Exception):
    """Error of a file that is no file of results, or is of another run: ``str(error)`` says why."""


@dataclass(frozen=True)
class SeedResult:
    """Outcome of a test at a seed; ``seed`` is None for a test without a bench."""

    piece: str
    """Node id, which repeats it: ``test_x.py::test_y[seed-17]``."""
    test: str
    """Node id without the seed."""
    seed: int | None
    outcome: str
    what: str = ""
    """Error in a line."""
    smallest: tuple[str, ...] | None = None
    """Faults with which it still fails, as ``packet_nak at s4.network``; None: they were not searched for."""
    faults: int = 0
    """Number of faults that the test asked for."""
    note: str = ""
    """Reason for which the search was broken off, or has no result."""
    duration_s: float = 0.0


def digest(pieces: Iterable[str]) -> str:
    """Mark of all pieces of a run, by which its shards know each other."""
    return hashlib.sha256("\n".join(sorted(pieces)).encode()).hexdigest()[:16]


def of_shard(pieces: Sequence[str], shard: Shard) -> list[str]:
    """Pieces of a shard: every n-th in the order of their names. All shards have all, and none twice."""
    return sorted(pieces)[shard.number - 1 :: shard.of]


class ResultsFile:
    """File that results are written to as they come."""

    def __init__(self, path: Path, shard: Shard) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = path.open("w", encoding="utf-8")
        self._count = 0
        self._write({"format": FORMAT, "hil": __version__, "shard": shard.number, "of": shard.of})

    def add(self, result: SeedResult) -> None:
        self._write({name: value for name, value in asdict(result).items() if value not in ("", None)})
        self._count += 1

    def close(self, told: Sequence[object] | None) -> None:
        """Write the end; a file without it is of a run that was killed. ``told``: number of the pieces of
        all shards, their mark, and the number of those of this one."""
        if told:
            pieces, mark, mine = told
            self._write({"end": self._count, "pieces": pieces, "run": mark, "mine": mine})
        self._file.close()

    def _write(self, row: dict[str, Any]) -> None:
        self._file.write(json.dumps(row) + "\n")
        self._file.flush()


@dataclass(frozen=True)
class ShardResults:
    """Results of one file. ``pieces``: number of those of all shards, ``run`` their mark, ``mine`` the number
    of those of this one; None and empty if the file has no end."""

    path: Path
    shard: Shard
    results: list[SeedResult]
    pieces: int | None = None
    run: str = ""
    mine: int | None = None


def read_results(path: Path) -> ShardResults:
    """Read a file of results; of one that was broken off what there is.

    Raises:
        ResultsRefused: it is none, or cannot be read.
    """
    try:
        rows = list(_rows(path.read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no text"
        raise ResultsRefused(f"{path}: {why}") from None
    if not rows or rows[0].get("format") != FORMAT:
        raise ResultsRefused(f"{path}: this is no file of results; give one of `pytest --hil-results FILE`")
    try:
        results = [_result(row) for row in rows[1:] if "end" not in row]
        of = ShardResults(path, Shard(rows[0]["shard"], rows[0]["of"]), results)
        end = rows[-1]
        return replace(of, pieces=end["pieces"], run=end["run"], mine=end["mine"]) if "end" in end else of
    except (KeyError, TypeError) as error:
        raise ResultsRefused(f"{path}: a line is not as pytest --hil-results writes it: {error}") from None


def _result(row: dict[str, Any]) -> SeedResult:
    smallest = row.get("smallest")
    told = {"seed": None} | row | {"smallest": None if smallest is None else tuple(smallest)}
    return SeedResult(**told)


def _rows(text: str) -> Iterator[dict[str, Any]]:
    for line in text.splitlines():
        try:
            row = json.loads(line)
        except ValueError:
            return  # it was killed in the middle of a line
        if not isinstance(row, dict):
            return
        yield row
