"""Questions that are asked again: on a link that comes back, a question or its answer may have been lost."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeVar

from hil.vocab.bridge_protocol import BenchGone
from hil.vocab.verbs import VerbRefused

ASKS = 3
"""Number of questions in the time for an answer; the bench that is asked knows them for one question."""
_LOST = "busy"
"""Code of a refusal that says nothing on the question: there was no room for it."""
Answer = TypeVar("Answer")


async def asked_again(ask: Callable[[float], Awaitable[Answer]], timeout_s: float) -> Answer:
    """Ask by ``ask``, which gets the time that is left, up to ``ASKS`` times in a row. The first answer
    counts, also of a question that was taken for lost.

    Raises:
        BenchGone: none came in time.
        VerbRefused: the question was refused.
    """
    loop = asyncio.get_running_loop()
    began_s = loop.time()
    asked: set[asyncio.Future[Answer]] = set()
    lost: BenchGone | VerbRefused | None = None
    try:
        for number in range(1, ASKS + 1):
            asked.add(asyncio.ensure_future(ask(began_s + timeout_s - loop.time())))
            until_s = began_s + timeout_s * number / ASKS
            while (left_s := until_s - loop.time()) > 0 or (number == ASKS and asked):
                if not asked:
                    await asyncio.sleep(left_s)
                    break
                done, asked = await asyncio.wait(
                    asked,
                    timeout=None if number == ASKS else left_s,
                    return_when=asyncio.FIRST_COMPLETED,
                )
                for question in done:
                    try:
                        return question.result()
                    except (BenchGone, VerbRefused) as error:
                        if isinstance(error, VerbRefused) and error.code != _LOST:
                            raise
                        lost = error
    finally:
        for question in asked:
            question.cancel()
    assert lost is not None
    raise lost
