"""``docs/reference.md`` is what the program prints."""

from pathlib import Path

from hil.daemon.cli import app
from hil.daemon.reference import reference

PAGE = Path(__file__).parent.parent / "docs" / "reference.md"


def test_the_reference_is_up_to_date() -> None:
    assert PAGE.read_text() == reference(app), "run: .venv/bin/hil reference > docs/reference.md"
