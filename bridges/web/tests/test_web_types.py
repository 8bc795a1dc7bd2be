"""The page's types of what the door tells are those of the rows and of the table of operations."""

import write_web_types


def test_they_are_fresh() -> None:
    assert write_web_types.FILE.read_text() == write_web_types.written(), "run `make web-types`"
