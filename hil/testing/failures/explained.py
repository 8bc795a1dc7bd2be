"""Explanation of a test that failed: sections for its report, and its folder of files."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from hil.testing.failures.bench_account import Section, bench_sections

if TYPE_CHECKING:
    from hil.testing.bench import Bench
    from hil.testing.served_bench import ServedBench


def explain(
    node_id: str,
    failure: str,
    benches: Sequence["Bench"],
    live: Sequence["ServedBench"],
    artifacts: Path | None,
) -> list[Section]:
    """Sections of the report. ``failure``: what pytest says; ``artifacts``: where a folder of files goes."""
    sections: list[Section] = []
    for bench in benches:
        sections += _tried(bench.config.bench, partial(bench_sections, bench))
    for served in live:
        sections += _tried("a live bench", served.state_now)
        sections += _tried("a live bench", served.report)
    if artifacts:
        sections += _tried(
            str(artifacts), lambda: [_kept(artifacts, node_id, failure, benches, live, sections)]
        )
    return sections


def _tried(what: str, tell: Callable[[], Iterable[Section]]) -> list[Section]:
    """Sections, as far as they can be told: whatever goes wrong here, the test's own failure is told."""
    told: list[Section] = []
    try:
        told.extend(tell())
    except Exception as error:
        told.append(("hil", f"not all is known of {what}: {type(error).__name__}: {error}"))
    return told


def _kept(
    artifacts: Path,
    node_id: str,
    failure: str,
    benches: Iterable["Bench"],
    live: Iterable["ServedBench"],
    sections: Sequence[Section],
) -> Section:
    from hil.testing.failures.failure_folder import FailureFolder

    folder = FailureFolder(artifacts, node_id)
    folder.add_sections(sections)
    for bench in benches:
        folder.add_sections(_tried(bench.config.bench, partial(folder.add_bench, bench)))
    for served in live:
        folder.add_sections(_tried("a live bench", partial(folder.add_live, served)))
    return "kept files", str(folder.write_page(failure))
