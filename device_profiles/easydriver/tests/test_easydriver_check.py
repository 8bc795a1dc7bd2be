"""The EasyDriver passes the checks of all boards."""

from pathlib import Path

from hil.testing import check_profile


def test_it_passes_the_checks_of_all_boards() -> None:
    check_profile(Path(__file__).parents[1])
