"""Rate at which messages of a page are read; more wait where they are."""

import asyncio


class MessageRate:
    """Messages of a second at once, then ``messages_per_s``. Time is given by the caller."""

    def __init__(self, messages_per_s: float) -> None:
        self._interval_s = 1 / messages_per_s
        self._free_at_s = 0.0
        """Time at which all messages of a second are free again."""

    def delay_s(self, now_s: float) -> float:
        """Count a message; answers how long it has to wait."""
        self._free_at_s = max(self._free_at_s, now_s) + self._interval_s
        return max(self._free_at_s - now_s - 1.0, 0.0)

    async def wait(self, now_s: float) -> None:
        """Count a message, and wait as long as it has to."""
        if delay_s := self.delay_s(now_s):
            await asyncio.sleep(delay_s)
