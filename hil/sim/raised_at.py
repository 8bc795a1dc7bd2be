"""Place in a board's own code at which an exception was raised, for the board's author."""

_HIL = __file__.removesuffix("sim/raised_at.py")


def place_of(error: BaseException) -> str:
    """Answer file and line as " (firmware.py:31)": of the innermost call outside ``hil``, where there is one;
    "" without a traceback."""
    places: list[tuple[str, int]] = []
    call = error.__traceback__
    while call:
        places.insert(0, (call.tb_frame.f_code.co_filename, call.tb_lineno))
        call = call.tb_next
    if not places:
        return ""
    file, line = next((each for each in places if not each[0].startswith(_HIL)), places[0])
    return f" ({file.rpartition('/')[2]}:{line})"
