"""A night in which a report of the guard was lost."""

from pathlib import Path

BOARDS = Path(__file__).parent / "boards"
NIGHT = Path(__file__).parent / "night.hilz"


def test_the_first_program_loses_a_report(recorded_bench):
    assert b"STOP" in said(recorded_bench(NIGHT, trust=True))


def test_the_second_program_loses_none(recorded_bench):
    mend = [f"profile_path={BOARDS}", "guard.profile=guard_2"]
    assert said(recorded_bench(NIGHT, settings=mend, trust=True)) == b"panel: the cell runs\r\n"


def said(bench):
    """All that the panel has printed."""
    return b"".join(data for _, data in bench.port("panel").timeline)
