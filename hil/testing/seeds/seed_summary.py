"""Summary of results at many seeds, for people."""

from collections.abc import Iterable, Iterator, Sequence

from hil.testing.seeds.seed_results import FAILED, SKIPPED, SeedResult

MOST_SHOWN = 20
"""Maximum number of seeds in a line."""
MOST_SETS = 5
"""Maximum number of smallest sets of one test in a summary; the files of results have all."""


def summary(results: Iterable[SeedResult]) -> list[str]:
    """Lines on tests that failed at seeds, and one on all."""
    by_test: dict[str, list[SeedResult]] = {}
    for each in results:
        if each.seed is not None:
            by_test.setdefault(each.test, []).append(each)
    lines = [line for test in sorted(by_test) for line in _of_test(test, by_test[test])]
    runs = sum(map(len, by_test.values()))
    failed = sum(each.outcome == FAILED for rows in by_test.values() for each in rows)
    skipped = sum(each.outcome == SKIPPED for rows in by_test.values() for each in rows)
    skips = f", {skipped} skipped" if skipped else ""
    lines.append(f"{_many(len(by_test), 'test')} at seeds: {runs} runs, {failed} failed{skips}")
    return lines


def _of_test(test: str, rows: Sequence[SeedResult]) -> Iterator[str]:
    failed = sorted((each for each in rows if each.outcome == FAILED), key=lambda each: each.seed or 0)
    if not failed:
        return
    yield f"{test} failed at {len(failed)} of {_many(len(rows), 'seed')}: {_seeds(failed)}"
    found: dict[str, list[SeedResult]] = {}
    for each in failed:
        found.setdefault(_smallest(each), []).append(each)
    for text, at in [*found.items()][:MOST_SETS]:
        if text:
            yield f"  {text} (at {_seeds(at)})"
    if len(found) > MOST_SETS:
        yield f"  and {len(found) - MOST_SETS} more sets of faults"
    yield f"  first: {failed[0].what}" if failed[0].what else "  first:"
    yield f"  again: pytest '{failed[0].piece}' --hil-seed {failed[0].seed}"


def _smallest(result: SeedResult) -> str:
    note = f"; {result.note}" if result.note else ""
    if result.smallest is None:
        return result.note
    if not result.smallest:
        return f"it fails without faults{note}"
    of = f"{len(result.smallest)} of {_many(result.faults, 'fault')}"
    return f"smallest set of faults: {', '.join(result.smallest)}; {of}{note}"


def _seeds(rows: Sequence[SeedResult]) -> str:
    more = f" and {len(rows) - MOST_SHOWN} more" if len(rows) > MOST_SHOWN else ""
    return ", ".join(str(each.seed) for each in rows[:MOST_SHOWN]) + more


def _many(count: int, what: str) -> str:
    return f"{count} {what}" + ("s" if count != 1 else "")
