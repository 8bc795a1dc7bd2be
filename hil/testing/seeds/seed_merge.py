"""Results of shards, joined: all of them, and none twice."""

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hil.testing.seeds.seed_results import (
    FAILED,
    PASSED,
    SKIPPED,
    ResultsRefused,
    SeedResult,
    ShardResults,
    digest,
    read_results,
)
from hil.testing.seeds.seed_summary import summary

_TEXT = dict.fromkeys([*range(9), 11, 12, *range(14, 32)])
"""Characters that XML 1.0 cannot have."""


@dataclass(frozen=True)
class Merged:
    """Results of all shards. ``problems``: shards that are missing, broken off or twice, for people."""

    results: list[SeedResult]
    problems: list[str]
    shards: int

    def count(self, outcome: str) -> int:
        """Number of results with an outcome."""
        return sum(each.outcome == outcome for each in self.results)

    @property
    def is_good(self) -> bool:
        """True if nothing is missing or twice, and nothing failed."""
        return not self.problems and not self.count(FAILED)

    def text(self) -> str:
        """Summary for people."""
        counts = f"{len(self.results)} results of {self.shards} shard{'s' if self.shards != 1 else ''}: " + (
            ", ".join(f"{self.count(each)} {each}" for each in (PASSED, FAILED, SKIPPED) if self.count(each))
            or "none"
        )
        others = [each for each in self.results if each.outcome == FAILED and each.seed is None]
        failed = [f"{each.piece} failed: {each.what}" for each in others]
        return "\n".join([*failed, *summary(self.results), counts, *self.problems])

    def junit(self) -> bytes:
        """Results as JUnit's XML, which most CI servers read."""
        suite = ET.Element("testsuite", name="hil seeds", tests=str(len(self.results)))
        suite.set("failures", str(self.count(FAILED)))
        suite.set("skipped", str(self.count(SKIPPED)))
        for each in self.results:
            file, _, name = each.piece.partition("::")
            where = file.removesuffix(".py").replace("/", ".")
            case = ET.SubElement(suite, "testcase", classname=where, name=name, time=f"{each.duration_s:f}")
            if each.outcome == FAILED:
                faults = (
                    "" if each.smallest is None else f"smallest set of faults: {', '.join(each.smallest)}"
                )
                failure = ET.SubElement(case, "failure", message=each.what.translate(_TEXT))
                failure.text = "\n".join(filter(None, (each.what, faults, each.note))).translate(_TEXT)
            elif each.outcome == SKIPPED:
                ET.SubElement(case, "skipped")
        suites = ET.Element("testsuites")
        suites.append(suite)
        text: bytes = ET.tostring(suites, "utf-8", xml_declaration=True)
        return text


def merge(paths: Sequence[Path]) -> Merged:
    """Join files of ``pytest --hil-shard``.

    Raises:
        ResultsRefused: one is no file of results, or is of another run than the first.
    """
    shards = [read_results(path) for path in paths]
    first = next((each for each in shards if each.run), shards[0])
    for each in shards:
        if each.shard.of != first.shard.of or (each.run and each.run != first.run):
            why = (
                f"{each.path} (shard {each.shard}) is of another run than {first.path} (shard {first.shard})"
            )
            raise ResultsRefused(f"{why}: they have other tests, other seeds or another number of shards")
    results, problems = list[SeedResult](), list[str]()
    for number in range(1, first.shard.of + 1):
        problems += _of_shard(number, [each for each in shards if each.shard.number == number], results)
    twice = [piece for piece, count in Counter(each.piece for each in results).items() if count > 1]
    problems += [f"{piece} was run in two shards" for piece in twice]
    if not problems and digest(each.piece for each in results) != first.run:
        problems.append(
            f"the results are not those of the {first.pieces} tests and seeds that were to be run"
        )
    return Merged(sorted(results, key=lambda each: (each.test, each.seed or 0)), problems, first.shard.of)


def _of_shard(number: int, files: Sequence[ShardResults], results: list[SeedResult]) -> list[str]:
    """Add the results of a shard; answers what is wrong with it."""
    if not files:
        return [f"shard {number} is missing"]
    last = files[-1]
    results += last.results
    problems = []
    if len(files) > 1:
        problems.append(f"shard {number} is there twice: {', '.join(str(each.path) for each in files)}")
    if last.mine is None:
        problems.append(f"shard {number} was killed after {len(last.results)} results: {last.path}")
    elif len(last.results) < last.mine:
        count = f"{len(last.results)} of {last.mine} results"
        problems.append(f"shard {number} ended early, with {count}: {last.path}")
    return problems
