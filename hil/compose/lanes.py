"""Choice of the lanes in which a core's axes move together: the widest that the processor has, unless the
environment says another. They give the same bits; the choice is for tests and for measuring."""

from collections.abc import Iterable, Mapping

from hil.core import Core
from hil.core.abi import Lanes


class LanesRefused(Exception):
    """Refusal of lanes that there are not: ``str(error)`` says why, and what there is."""


def choose_lanes(core: Core, environ: Mapping[str, str]) -> None:
    """Let a core have the lanes that the environment wants.

    Raises:
        LanesRefused: there are none of that name, or this processor cannot run them.
    """
    wanted = environ.get("HIL_LANES", "")
    if not wanted:
        return
    if wanted not in Lanes.__members__:
        raise LanesRefused(f"HIL_LANES: there are no lanes {wanted!r}: use {_names(Lanes)}")
    try:
        core.native.set_lanes(Lanes[wanted])
    except ValueError:
        here = _names(each for each in Lanes if each <= core.native.lanes)
        raise LanesRefused(
            f"HIL_LANES: this processor does not have the instructions of the lanes {wanted}: use {here}"
        ) from None


def _names(lanes: Iterable[Lanes]) -> str:
    *others, last = (each.name for each in lanes)
    return f"{', '.join(others)} or {last}"
