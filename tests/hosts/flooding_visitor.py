"""Program on a computer of its own that asks and sends as fast as it can.

Called as KIND CONFIG BENCH; CONFIG is a user's zenoh.json, or paths and values as JSON. It says ``up`` once
it has a session, and goes on until it is killed.
"""

import itertools
import json
import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import zenoh

from hil.client.link import from_file

DEEP = b"[" * 5000
KEYS = (
    "axis/m1/cmd/move_abs",
    "axis/m1/cmd/%d",
    "axis/none/cmd/enable",
    "run/submit",
    "axis/m1/fault",
    "axis/m1/param/pKp",
    "a/b/c/d/e",
    "run/" + "z" * 200 + "/cancel",
    "axis/m1/cmd/" + "y" * 5000,
    "sim/rejected",
)
PAYLOADS = (
    b"",
    b"{",
    b"null",
    b"[]",
    b'{"position_deg": 1e999}',
    b'{"position_deg": NaN}',
    b'{"position_deg": ' + b"9" * 5000 + b"}",
    b'{"position_deg": "' + b"9" * 4300 + b'"}',
    b"\xff\xfe\x00",
    DEEP,
    b'{"a":' * 2000,
    b"{" + b'"k": 1,' * 5000 + b'"z": 2}',
    b"x" * 200_000,
)
ATTACHMENTS = (
    None,
    b"",
    b"{",
    b"{}",
    DEEP,
    b'{"user": "otto", "at_ns": 1, "nonce": "a", "mac": "b"}',
    b"\x00" * 70_000,
)
NONE = zenoh.ConsolidationMode.NONE


def ignore(_: zenoh.Reply) -> None:
    """Take a reply."""


def malformed(session: zenoh.Session, root: str) -> Callable[[int], Any]:
    """Puts and questions that are none."""
    drawn = random.Random(1)

    def one(number: int) -> None:
        key = f"{root}/{drawn.choice(KEYS)}".replace("%d", str(number))
        payload, attachment = drawn.choice(PAYLOADS), drawn.choice(ATTACHMENTS)
        if number % 2:
            session.put(key, payload, attachment=attachment)
        else:
            session.get(key, handler(), payload=payload, attachment=attachment, timeout=5)

    return one


def questions(session: zenoh.Session, root: str) -> Callable[[int], Any]:
    return lambda _: session.get(f"{root}/sim/health", handler(), timeout=5)


def wide(session: zenoh.Session, root: str) -> Callable[[int], Any]:
    """Questions that every key answers."""
    return lambda _: session.get(f"{root}/**", handler(), timeout=5, consolidation=NONE)


def runs(session: zenoh.Session, root: str) -> Callable[[int], Any]:
    """A run each time, whether it may be or not."""
    text = "run: q{}\naxes: {{m1: {{}}}}\nsteps: [{{dwell_s: 1}}]\n"
    return lambda number: session.get(
        f"{root}/run/submit", handler(), payload=text.format(number).encode(), timeout=5
    )


KINDS = {each.__name__: each for each in (malformed, questions, wide, runs)}


def handler() -> Any:
    return zenoh.handlers.Callback(ignore, indirect=False)


def main() -> None:
    kind, given, bench = sys.argv[1:]
    if given.endswith(".json"):
        config = zenoh.Config.from_json5(json.dumps(from_file(Path(given))[0]))
    else:
        config = zenoh.Config()
        for path, value in json.loads(given).items():
            config.insert_json5(path, json.dumps(value))
    with zenoh.open(config) as session:
        print("up", flush=True)
        one = KINDS[kind](session, f"hil/{bench}")
        for number in itertools.count():
            one(number)


if __name__ == "__main__":
    main()
