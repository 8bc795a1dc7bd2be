"""Processes in the network namespaces of ``test_zenoh_namespaces.py``: a daemon's session with stand-ins
behind it that note what reaches them, and attackers. A program: zenoh_attacks.py WHAT GIVEN (JSON).
"""

import json
import re
import secrets
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import zenoh

from bridges.zenoh.bench_session import open_session
from bridges.zenoh.gate import Gate, Rejected
from bridges.zenoh.options import Options
from bridges.zenoh.zenoh_config import made
from hil.net.signature import signed
from hil.vocab.verbs import Role

DAEMON, ATTACKER = "10.213.0.1", "10.213.0.2"
DEADLINE_S = 20.0
LIVE = "@live/daemon"
READ = (
    "axis/m1/state",
    "axis/*/state",
    "axis/m1/param/pKp",
    "segment/s/stats",
    "sim/clock",
    "verbs/m1",
    "layout",
)
COMMANDS = ("axis/m1/cmd/go", "axis/m1/param/pKp")
FAULTS = ("axis/m1/fault", "segment/s/fault")
NEVER = ("axis/m1/state", "sim/clock", "segment/s/packets", "port/p/tx", "verbs/m1", "layout", "other")
TOLD = ("axis/m1/state", "segment/s/packets", "port/p/rx", "sim/clock")
UNTOLD = "axis/m1/cmd/echo"
"""Key that the daemon's side publishes but clients do not get: it stands for another client's command."""
USERS = {"vic": Role.VIEWER, "opa": Role.OPERATOR, "ada": Role.ADMIN}


def ours(key: str) -> str:
    return f"hil/b/{key}"


class StandIn:
    """The daemon's side of the session."""

    def __init__(self, options: Options) -> None:
        self.session, self.gate = open_session(options, "b")
        self.heard: list[list[str]] = []
        self.stop = threading.Event()
        remote = zenoh.Locality.REMOTE
        self.entities = [
            self.session.declare_subscriber(ours("**"), self.on_put, allowed_origin=remote),
            self.session.declare_queryable(ours("**"), self.on_query, complete=True),
            self.session.liveliness().declare_token(ours(LIVE)),
        ]
        self.teller = threading.Thread(target=self.tell)
        self.teller.start()

    def tell(self) -> None:
        while not self.stop.wait(0.02):
            for key in (UNTOLD, *TOLD):
                self.session.put(ours(key), b"genuine")

    def note(self, what: str, key: str, payload: Any, attachment: Any) -> None:
        who = ""
        if re.search("/(cmd|param|fault)", key) and (payload or what != "query"):
            text = attachment.to_bytes() if attachment else None
            who = verdict(self.gate, text, key, payload.to_bytes() if payload else b"")
        self.heard.append([what, key.removeprefix(ours("")), who])

    def on_put(self, sample: zenoh.Sample) -> None:
        what = "put" if sample.kind == zenoh.SampleKind.PUT else "delete"
        self.note(what, str(sample.key_expr), sample.payload, sample.attachment)

    def on_query(self, query: zenoh.Query) -> None:
        key = str(query.key_expr)
        self.note("query", key, query.payload, query.attachment)
        query.reply(ours("axis/m1/state") if "*" in key else key, b"genuine")
        query.drop()

    def settled(self) -> list[list[str]]:
        """Wait until nothing more is heard, and return all that was: callbacks have threads of their own."""
        heard: list[list[str]] | None = None
        while heard is None or heard != self.heard:
            heard = list(self.heard)
            self.stop.wait(0.1)
        return heard

    def report(self) -> dict[str, Any]:
        """Report what was heard since the last report, and what this side sees of others."""
        heard = self.settled()
        live = [str(each.ok.key_expr) for each in self.session.liveliness().get("**/@live/**") if each.ok]
        answers = self.session.get(ours("axis/m1/state"), consolidation=zenoh.ConsolidationMode.NONE)
        genuine = [each.ok.payload.to_string() for each in answers if each.ok]
        self.heard.clear()
        return {
            "heard": heard,
            "alive": live,
            "answers": genuine,
            "peers": len(self.session.info.peers_zid()),
            "sockets": sockets(),
        }

    def close(self) -> None:
        self.stop.set()
        self.teller.join()
        self.session.close()


def verdict(gate: Gate | None, attachment: bytes | None, key: str, payload: bytes) -> str:
    if gate is None:
        return "no gate"
    try:
        return gate.check(attachment, key, payload, time.time_ns()).name
    except Rejected as rejected:
        return "rejected: " + re.split("[:;]", str(rejected))[0]


def sockets() -> list[str]:
    """Local addresses in this namespace that TCP listens on or that UDP is bound to, in hexadecimal."""
    found = []
    for kind, state in (("tcp", "0A"), ("tcp6", "0A"), ("udp", "07"), ("udp6", "07")):
        path = Path(f"/proc/self/net/{kind}")
        for line in path.read_text().splitlines()[1:] if path.exists() else []:
            fields = line.split()
            if fields[3] == state:
                found.append(f"{kind} {fields[1]}")
    return found


def serve(options: Options) -> None:
    """Run the stand-in until standard input ends, and answer each line of it with a report."""
    stand_in = StandIn(options)
    say({"ready": True})
    for _ in sys.stdin:
        say(stand_in.report())
    stand_in.close()


def opened(config: Mapping[str, Any] | str) -> Any:
    """A session of a configuration, or of the path of a file with one."""
    return zenoh.open(zenoh.Config.from_file(config) if isinstance(config, str) else made(config))


def attack(config: Mapping[str, Any] | str, user: str | None, secret: str | None) -> None:
    """Try everything, say what came of it, and stay until the input ends."""
    try:
        session = opened(config)
    except zenoh.ZError as error:
        say({"opened": False, "why": str(error).partition(" at /")[0]})
        return
    with session:
        heard = {"narrow": set[str](), "alive": set[str]()}
        told = threading.Semaphore(0)

        def narrow(sample: zenoh.Sample) -> None:
            heard["narrow"].add(str(sample.key_expr).removeprefix(ours("")))
            told.release()

        remote = zenoh.Locality.REMOTE
        alive = session.liveliness()
        # Declared here and used later: once zenoh has heard that nobody is at the other end, they are silent.
        publisher = session.declare_publisher(ours("axis/m1/cmd/publisher"))
        querier = session.declare_querier(ours("axis/m1/param/querier"))
        # Before the subscriber: while that waits for its first tokens, zenoh 1.10 answers without them.
        asked_alive = [str(reply.ok.key_expr) for reply in alive.get(ours("@live/**"), timeout=3) if reply.ok]
        kept = [
            session.declare_subscriber(ours("**"), narrow, allowed_origin=remote),
            alive.declare_subscriber(
                ours("@live/**"), lambda sample: heard["alive"].add(str(sample.key_expr)), history=True
            ),
            session.declare_queryable(ours("axis/m1/state"), lambda query: forge(query), complete=True),
            alive.declare_token(ours("@live/axis/forged")),
        ]

        def sign(key: str, payload: bytes) -> bytes | None:
            if user is None or secret is None:
                return None
            return signed(user, secret, key, payload, time.time_ns(), secrets.token_hex(8))

        def ask(key: str, payload: bytes | None = None) -> int:
            replies = session.get(
                ours(key),
                payload=payload,
                attachment=sign(ours(key), payload or b""),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,  # beside its own forged answer
                timeout=3,
            )
            return sum(
                reply.ok is not None and reply.ok.payload.to_bytes() == b"genuine" for reply in replies
            )

        for key in (*COMMANDS, *FAULTS, *NEVER, LIVE):
            session.put(ours(key), b"evil", attachment=sign(ours(key), b"evil"))
            session.delete(ours(key))
        session.put(ours(COMMANDS[0]), b"unsigned")
        again = sign(ours(COMMANDS[0]), b"again")
        for _ in range(2):
            session.put(ours(COMMANDS[0]), b"again", attachment=again)
        publisher.put(b"evil", attachment=sign(ours("axis/m1/cmd/publisher"), b"evil"))
        session.put("@/*/router/config/access_control/enabled", b"false")
        answered = [key for key in (*READ, "**", "other") if ask(key)]
        commanded = [key for key in (*COMMANDS, *FAULTS) if ask(key, b"1")]
        if any(reply.ok for reply in querier.get()):
            answered.append("querier")
        own = str(session.zid())
        admin = [str(reply.ok.key_expr) for reply in session.get("@/**", timeout=3) if reply.ok]
        for _ in range(3 * len(TOLD)):
            if not told.acquire(timeout=2.0 if answered else 0.2):
                break
        links = len(list(session.info.links()))
        wide = listen_wide(config)
        mine = {ours("@live/axis/forged")}
        say(
            {
                "opened": True,
                "links": links,
                "answered": answered,
                "commanded": commanded,
                "narrow": sorted(heard["narrow"]),
                "wide": wide,
                "alive": sorted(heard["alive"] - mine),
                "asked_alive": sorted(set(asked_alive) - mine),
                "admin": [key for key in admin if own not in key],
            }
        )
        sys.stdin.read()
        for entity in kept:
            entity.undeclare()


def forge(query: zenoh.Query) -> None:
    query.reply(str(query.key_expr), b"forged")
    query.drop()


def listen_wide(config: Mapping[str, Any] | str) -> list[str]:
    """Keys that a client gets which asks for more than the bench's own. Uses a session of its own: what one
    subscriber of a session may have, its other subscribers see too."""
    heard: set[str] = set()
    clocks = threading.Semaphore(0)

    def on_any(sample: zenoh.Sample) -> None:
        heard.add(str(sample.key_expr))

    with suppress(zenoh.ZError):
        session = opened(config)
        with session:
            replies = session.liveliness().get("hil/*/@live/**", timeout=3)
            heard |= {str(reply.ok.key_expr) for reply in replies if reply.ok}
            session.declare_subscriber("**", on_any)
            session.declare_subscriber("hil/**", on_any)
            session.liveliness().declare_subscriber("hil/*/@live/**", on_any, history=True)
            session.declare_subscriber(ours("sim/clock"), lambda _: clocks.release())
            for _ in range(5):
                if not clocks.acquire(timeout=1.0):
                    break
    return sorted(heard - {ours("sim/clock"), ours("@live/axis/forged")})


def count_multicast(for_s: float) -> int:
    """IPv4 frames to groups that pass this namespace's interfaces until a time after a line was read."""
    import socket

    count = 0
    with socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0003)) as raw:
        say({"ready": True})
        sys.stdin.readline()
        until_s = time.monotonic() + for_s
        while (left_s := until_s - time.monotonic()) > 0:
            raw.settimeout(left_s)
            with suppress(TimeoutError):
                packet = raw.recv(65536)
                count += len(packet) > 16 and packet[0] >> 4 == 4 and packet[16] >> 4 == 14
    return count


def say(what: Mapping[str, Any]) -> None:
    print(json.dumps(what), flush=True)


def main(what: str, given: Any) -> None:
    if what == "serve":
        serve(Options.model_validate_json(json.dumps(given)))
    elif what == "attack":
        attack(given["config"], given["user"], given["secret"])
    elif what == "open":
        session: Any = zenoh.open(zenoh.Config())
        say({"ready": True})
        sys.stdin.read()
        session.close()
    elif what == "count":
        say({"count": count_multicast(given)})


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]))
