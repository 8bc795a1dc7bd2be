"""Tables of the page are those of the daemon: of the door, of documents and of G-code."""

import write_web_types
import write_web_words


def test_they_are_fresh() -> None:
    assert write_web_types.FILE.read_text() == write_web_types.written(), "run `make web-types`"


def test_words_of_the_editors_are_fresh() -> None:
    assert write_web_words.FILE.read_text() == write_web_words.written(), "run `make web-types`"
