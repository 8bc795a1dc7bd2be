"""Place at which a board's program raised, as its stop says it."""

import pytest

from hil.sim.firmware_guard import place_of


def raised(code: str, file: str) -> BaseException:
    try:
        exec(compile(code, file, "exec"), {"inner": place_of})
    except Exception as error:
        return error
    raise AssertionError("nothing was raised")


def test_a_board_of_ones_own_is_named_by_file_and_line() -> None:
    assert place_of(raised("x = 1\ny = x + None", "/home/me/boards/thermo/firmware.py")) == " (firmware.py:2)"


def test_the_innermost_call_outside_hil_is_named() -> None:
    assert place_of(raised("\n\ninner(None)", "/home/me/boards/thermo/firmware.py")) == " (firmware.py:3)"


def test_hils_own_mistake_has_its_place() -> None:
    with pytest.raises(AttributeError) as raised_here:
        place_of(None)  # type: ignore[arg-type]
    raised_here.value.__traceback__ = raised_here.tb.tb_next
    assert place_of(raised_here.value).startswith(" (firmware_guard.py:")


def test_what_was_never_raised_has_no_place() -> None:
    assert place_of(ValueError()) == ""
