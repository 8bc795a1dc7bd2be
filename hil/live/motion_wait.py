"""A wait for the end of a motion that a verb began, of a twin and of a real drive alike."""

import asyncio
from collections.abc import Callable

from hil.vocab.verbs import VerbRefused


async def motion_ended(
    was_cut_short: Callable[[], bool | None],
    now_ns: Callable[[], int],
    effective_at_ns: int,
    at_most_s: float,
    pause_s: Callable[[], float],
) -> dict[str, bool]:
    """Wait until a motion has ended; answers if something else ended it. ``was_cut_short``: None while it
    goes on; ``pause_s``: time until the next look at it. Raises VerbRefused: it takes too long."""
    while (is_short := was_cut_short()) is None:
        if now_ns() >= effective_at_ns + at_most_s * 1e9:
            raise VerbRefused("not_now", f"it has not ended after {at_most_s:g} s; ask for its state")
        await asyncio.sleep(pause_s())
    return {"interrupted": is_short}
