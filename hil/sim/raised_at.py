"""Place in a board's own code at which an exception was raised, for the board's author."""

_ROOT = __file__.removesuffix("hil/sim/raised_at.py")
_OURS = f"{_ROOT}hil/", f"{_ROOT}bridges/"
"""Folders of the code that carries a board's out: the bench, and buses."""


def place_of(error: BaseException) -> str:
    """Answer file and line as " (firmware.py:31)": of the innermost call outside of these, if there is one;
    "" without a traceback."""
    places: list[tuple[str, int]] = []
    call = error.__traceback__
    while call:
        places.insert(0, (call.tb_frame.f_code.co_filename, call.tb_lineno))
        call = call.tb_next
    if not places:
        return ""
    file, line = next((each for each in places if not each[0].startswith(_OURS)), places[0])
    return f" ({file.rpartition('/')[2]}:{line})"
