"""``hil seeds``: results of tests that ran at many seeds, in shards."""

from pathlib import Path
from typing import Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer


def merge(
    results: Annotated[
        list[Path],
        typer.Argument(help="Files of `pytest --hil-shard`.", show_default=False),
    ],
    junit: Annotated[
        Path | None, typer.Option("--junit", help="Also write the results as JUnit's XML.")
    ] = None,
) -> CommandAnswer:
    """Join the results of all shards of a test run.

    Names the tests with the seeds at which they fail, and the smallest sets of faults. Exits with 1 if one
    failed, or if a shard is missing, was broken off or is there twice.

    Example: hil seeds merge hil-results-1-of-2.jsonl hil-results-2-of-2.jsonl
    """
    from dataclasses import asdict

    from hil.cli.framework.progress_bars import bar
    from hil.host.new_file import write_file
    from hil.testing.seeds.seed_merge import merge as join
    from hil.testing.seeds.seed_results import FAILED, PASSED, SKIPPED, ResultsRefused

    try:
        with bar("results are joined"):
            merged = join(results)
    except ResultsRefused as error:
        raise fail(f"hil: {error}", 2) from None
    try:
        if junit:
            write_file(junit, merged.junit())
    except OSError as error:
        raise fail(f"hil: {junit}: {error.strerror}") from None
    failed = [asdict(each) for each in merged.results if each.outcome == FAILED]
    counts = {outcome: merged.count(outcome) for outcome in (PASSED, FAILED, SKIPPED)}
    answer = counts | {"shards": merged.shards, "problems": merged.problems, "failures": failed}
    return CommandAnswer(answer, merged.text(), 0 if merged.is_good else 1)
