"""Work on long texts in a thread: ports, runs and clients do not wait for it."""

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

SHORT = 8192
"""Characters of a run that is read and planned at once: some 50 ms at most."""
T = TypeVar("T")


async def off_loop(text: str, call: Callable[..., T], *arguments: Any) -> T:
    """``call`` with the arguments, in a thread if the text that they come from is long."""
    if len(text) <= SHORT:
        return call(*arguments)
    return await asyncio.get_running_loop().run_in_executor(None, partial(call, *arguments))
