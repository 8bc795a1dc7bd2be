"""Programs that know zenoh and nothing else of ours, and a daemon with a door for them."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import zenoh
from e2e_support import PATIENCE_S, Place, Server, config, free_port

SAC = {"profile": "sac", "flash": {}}
QUIET: dict[str, Any] = {"scouting/multicast/enabled": False, "scouting/gossip/enabled": False}
NONE = zenoh.ConsolidationMode.NONE


def session(**values: Any) -> zenoh.Session:
    made = zenoh.Config()
    for path, value in (QUIET | {name.replace("__", "/"): v for name, v in values.items()}).items():
        made.insert_json5(path, json.dumps(value))
    return zenoh.open(made)


class Plain:
    """A program that knows zenoh and nothing else of ours."""

    def __init__(self, port: int) -> None:
        self.session = session(mode="client", connect__endpoints=[f"tcp/127.0.0.1:{port}"])

    def get(
        self, key: str, payload: str | bytes | None = None, timeout_s: float = PATIENCE_S
    ) -> list[dict[str, Any]]:
        """Replies as objects; of an error too, which has a code."""
        replies = self.session.get(f"hil/t/{key}", payload=payload, timeout=PATIENCE_S, consolidation=NONE)
        texts = [(reply.ok or reply.err).payload.to_string() for reply in replies]  # type: ignore[union-attr]
        return [json.loads(text) for text in texts]

    def one(self, key: str, payload: str | bytes | None = None) -> dict[str, Any]:
        (answer,) = self.get(key, payload)
        return answer

    def listen(self, key: str) -> tuple[list[zenoh.Sample], Any]:
        heard: list[zenoh.Sample] = []
        return heard, self.session.declare_subscriber(f"hil/t/{key}", heard.append)


class Bench:
    """A running daemon with a door, a servo and two steppers on a segment."""

    def __init__(self, place: Place, speed: float = 1, **bridge: Any) -> None:
        self.port = free_port()
        options = {"listen": [f"tcp/127.0.0.1:{self.port}"], "packed_hz": 1000, "state_hz": 50} | bridge
        stream = {"timeout_ms": 200, "policy": "decelerate"}
        text = config(
            speed=speed,
            devices={"m1": {"setpoints": stream}, "s1": SAC, "s2": SAC},
            segments={"bus0": {"stations": ["s1", "s2"], "taps": {"m": {"port": "pty"}}}},
            bridges={"zenoh": options},
        )
        self.server: Server = place.serve(text).ready()
        self.plain = Plain(self.port)

    @property
    def endpoint(self) -> str:
        return f"tcp/127.0.0.1:{self.port}"

    def bridge(self) -> dict[str, Any]:
        status: dict[str, Any] = self.server.ask("status")["bridges"]["zenoh"]
        return status


@contextmanager
def zenoh_bench() -> Iterator[Bench]:
    """Daemon with a door for zenoh, and a session at it."""
    with Place() as place:
        made = Bench(place)
        yield made
        made.plain.session.close()  # type: ignore[no-untyped-call]
