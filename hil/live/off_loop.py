"""Long work in a thread: ports, runs and clients do not wait for it."""

import asyncio
from collections.abc import Callable, Sized
from functools import partial
from typing import Any, TypeVar

SHORT = 8192
"""Maximum characters of a run, or rows, that are worked on at once: some 50 ms."""
T = TypeVar("T")


async def off_loop(source: Sized, call: Callable[..., T], *arguments: Any) -> T:
    """Call with the arguments, in a thread if their source is long: a text, rows."""
    if len(source) <= SHORT:
        return call(*arguments)
    return await asyncio.get_running_loop().run_in_executor(None, partial(call, *arguments))
