"""Dialogue of a test with a board at a port, in simulated time."""

from collections.abc import Callable

from hil.testing.faces import PortFace
from hil.vocab.dialogue import Dialogue, Heard, Listen, Result, Send
from hil.vocab.time import NS_PER_MS, SimTimeNs

LISTEN_SLICE_NS = 10 * NS_PER_MS
"""Time that a dialogue that listens lets pass between two looks at the port."""


def talk_at(
    port: PortFace,
    dialogue: Dialogue[Result],
    now_ns: Callable[[], SimTimeNs],
    run_until: Callable[[SimTimeNs], None],
) -> Result:
    """Carry out a dialogue at a port; answers its result. ``now_ns``: of the bench, whose time ``run_until``
    lets pass."""
    heard: list[tuple[SimTimeNs, bytes]] = []
    answer: Heard | None = None
    try:
        while True:
            step = dialogue.send(answer)
            answer = None
            if isinstance(step, Send):
                port.write(step.data)
            elif isinstance(step, Listen):
                end_ns = now_ns() + step.timeout_ns
                while (not heard or heard[0][0] > now_ns()) and now_ns() < end_ns:
                    next_ns = heard[0][0] if heard else now_ns() + LISTEN_SLICE_NS
                    run_until(SimTimeNs(min(next_ns, end_ns)))
                    heard += port.read_characters()
                is_there = heard and heard[0][0] <= now_ns()
                answer = Heard(*heard.pop(0)) if is_there else Heard(now_ns(), b"")
    except StopIteration as done:
        result: Result = done.value
        return result
