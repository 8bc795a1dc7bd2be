"""Stop of this bench, and of all benches that it is joined with."""

import asyncio
import time
from dataclasses import dataclass
from inspect import isawaitable
from typing import Any

from hil.live.configured import Configured
from hil.live.runs.other_benches import OtherBenches
from hil.operations.halt_operation import HaltOperation
from hil.operations.table import Asked
from hil.vocab.axis import How


@dataclass(frozen=True)
class SiteStop:
    """Stop of a site, asked for at one of its benches, whose own axes are told first."""

    configured: Configured
    halts: HaltOperation
    others: OtherBenches

    async def stop(self, asked: Asked, how: How, within_s: float) -> dict[str, Any]:
        """Stop all; answers a row for each bench, as ``hil.net.site_stop.Row``."""
        began_s = time.monotonic()
        doing = self.halts.halt(asked, how)
        others = asyncio.ensure_future(self.others.stop(asked.source, how, within_s))
        own: dict[str, Any] = {"bench": self.configured.config.bench, "state": "confirmed", "why": None}
        try:
            stopped = await doing if isawaitable(doing) else doing
            own["took_s"] = time.monotonic() - began_s
            return {"benches": [own | stopped, *await others]}
        finally:
            others.cancel()
