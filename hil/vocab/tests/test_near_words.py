"""Words that are near a mistyped one, asked for in one form."""

from pathlib import Path

import pytest

from hil.vocab.near_words import did_you_mean, meant, nearest_or_begun, nearest_or_longer

ROOT = Path(__file__).parents[3]


def test_all_ask_in_the_same_form() -> None:
    files = [file for init in ROOT.glob("*/__init__.py") for file in init.parent.rglob("*.py")]
    asking = {
        file.name
        for file in files
        if "tests" not in file.parts and "did you mean" in file.read_text().lower()
    }
    assert len(files) > 100
    assert asking == {"near_words.py"}


@pytest.mark.parametrize(
    ("word", "known", "near"),
    [
        ("stat", ["status", "state", "run"], ["status", "state"]),
        ("Mov-Abs", ["move_rel", "move_abs"], ["move_abs"]),
        ("move", ["position", "mode", "move-abs", "move-rel"], ["move-abs", "move-rel"]),
        ("drop", ["byte_drop", "byte_flip"], ["byte_drop"]),
        ("x", ["status", "run"], []),
        ("s", ["status", "run"], []),
    ],
)
def test_what_is_begun_comes_first_then_the_nearest(word: str, known: list[str], near: list[str]) -> None:
    assert nearest_or_begun(word, known) == near


def test_a_letter_that_is_left_out_asks_for_one_word() -> None:
    assert nearest_or_longer("por", ["ports", "port"]) == ["port"]
    assert nearest_or_longer("move", ["mode", "move-abs"]) == ["move-abs"]
    assert nearest_or_longer("NEMA-2", ["nema-2", "nema-2-long"]) == ["nema-2"]


def test_questions_and_what_there_is() -> None:
    assert did_you_mean() == did_you_mean(None) == ""
    assert did_you_mean("a", "b", "c") == 'did you mean "a" or "b" or "c"?'
    assert meant("m11", ["m1", "s1"]) == 'did you mean "m1"? there are m1, s1'
    assert meant("zz", []) == "there are none"
    assert meant("m11", ["m1"], "it takes m1") == 'did you mean "m1"? it takes m1'
