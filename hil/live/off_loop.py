"""Work on what is long in a thread: ports, runs and clients do not wait for it."""

import asyncio
from collections.abc import Callable, Sized
from functools import partial
from typing import Any, TypeVar

SHORT = 8192
"""Characters of a run that is read and planned at once, or rows that are checked: some 50 ms at most."""
T = TypeVar("T")


async def off_loop(source: Sized, call: Callable[..., T], *arguments: Any) -> T:
    """``call`` with the arguments, in a thread if what they come from is long: a text, rows."""
    if len(source) <= SHORT:
        return call(*arguments)
    return await asyncio.get_running_loop().run_in_executor(None, partial(call, *arguments))
