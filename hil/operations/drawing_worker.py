"""Process that plans one drawing and ends: ``python -m hil.operations.drawing_worker``.

It reads a pickle of a ``DrawingRequest``, which its daemon wrote, and answers as ``HEAD`` says. What it may
use of the computer is limited here.
"""

import json
import os
import pickle
import resource
import sys
from collections.abc import Mapping
from typing import Any

from hil.operations.drawing_request import HEAD, DrawingRequest
from hil.toolpath.bench_drawing import planned_drawing
from hil.vocab.text_digest import text_digest

PLANNING_S = 60
"""Maximum CPU time. The largest drawing takes a sixth of it."""
MEMORY_BYTES = 2 << 30
"""Maximum address space. The largest drawing takes half a gigabyte."""
ANSWER_BYTES = 32 << 20
"""Maximum length of an answer: the last one is kept."""
NICE = 10
CHECKED = ("problems", "of", "remarks", "machine", "figures")
"""Keys of the answer to a check."""


def answered(request: DrawingRequest) -> bytes:
    """Plan a drawing; answers what the daemon reads."""
    text, machine, file, machine_file, feed_percent, axes, is_check = request
    answer = planned_drawing(text, machine, file, machine_file, feed_percent / 100, axes)
    digest = ""
    if not answer["problems"]:
        answer, digest = with_digests(answer, text, machine)
    if is_check:
        answer = {key: each for key, each in answer.items() if key in CHECKED}
    content = _content(answer)
    if len(content) > ANSWER_BYTES:
        what = f"{file}: the path and its runs are {len(content)} bytes; {ANSWER_BYTES} are the most"
        answer = {"problems": [f"{what} (allow a larger tolerance, or make several programs of it)"]}
        content = _content(answer | {"of": "program"})
    texts = {"text": text, "machine_text": machine, "file": file, "feed_percent": feed_percent}
    head = HEAD.pack(not answer["problems"], digest.encode(), len(content))
    return b"".join((head, content, b",", _content(texts)[1:], b"}"))


def with_digests(answer: Mapping[str, Any], text: str, machine: str) -> tuple[dict[str, Any], str]:
    """Add the digests by which all who look on know a drawing and its runs; answers that of the drawing.

    Each run has the digest of its text, which its progress has too. The drawing's is of program, machine and
    runs: the same texts planned from elsewhere are another drawing.
    """
    runs = [{**run, "digest": text_digest(run["text"])} for run in answer["runs"]]
    digest = text_digest(text, machine, *(run["text"] for run in runs))
    return {**answer, "digest": digest, "runs": runs}, digest


def _content(answer: Mapping[str, Any]) -> bytes:
    """Encode without the last bracket."""
    return json.dumps(answer, separators=(",", ":")).encode()[:-1]


def main() -> None:
    os.nice(NICE)
    resource.setrlimit(resource.RLIMIT_CPU, (PLANNING_S, PLANNING_S + 1))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    sys.stdout.buffer.write(answered(pickle.load(sys.stdin.buffer)))


if __name__ == "__main__":
    main()
