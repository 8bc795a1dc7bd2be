import pytest

from hil.cli.framework.shown_words import first_keys


@pytest.mark.parametrize(
    ("greeting", "words"),
    [
        ("", ""),
        ("p", "type p"),
        ("\r", "press Enter"),
        ("v?\r\n", "type v? and press Enter"),
        ("\x1b", r"type '\x1b'"),
    ],
)
def test_words_for_what_is_typed(greeting: str, words: str) -> None:
    assert first_keys(greeting) == words
