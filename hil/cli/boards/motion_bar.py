"""Bar of a motion that a command waits for, on the bench's clock."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any

from hil.cli.framework.ask import BenchOptions
from hil.cli.framework.progress_bars import Look, ShownProgress, bar
from hil.net.control_client import ask

_PATIENCE_S = 1.0
_DOES = {"calibrate": "calibrates", "reset": "starts", "type": "answers"}
"""Words for what a device does by a verb, where it does not move."""


def motion_bar(
    bench: BenchOptions, device: str, verb: str, answer: Mapping[str, Any]
) -> AbstractContextManager[ShownProgress]:
    """Show how far a motion is that a verb began: of the time that it takes, where its answer says that."""
    what = f"{device} {_DOES.get(verb, 'moves')}"
    return bar(what, "s simulated", _look(bench, answer))


def _look(bench: BenchOptions, answer: Mapping[str, Any]) -> Look:
    path, takes_s = bench.meant().socket, (answer.get("ends_after_ns") or 0) / 1e9

    def look() -> tuple[float, float]:
        now_ns = ask(path, "status", timeout_s=_PATIENCE_S)["sim_ns"]
        return (now_ns - answer["effective_at_ns"]) / 1e9, takes_s

    return look
