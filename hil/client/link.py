"""Session with a bench, and the exchanges that both kinds of client make over it. Everything here blocks."""

import json
import re
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zenoh

from hil.client.door import AWAY_S, opened
from hil.client.messages import Ack, ClientError, ack_of, error_of, read
from hil.net.signature import KeySigner, signed, signer_of_files

ENDPOINT = "tcp/127.0.0.1:7447"
TIMEOUT_S = 5.0
MESSAGE_BYTES = 1_000_000
"""Maximum length of a message that a daemon takes."""
_LOOK_AGAIN_S = 0.05
BENCH_NAME = re.compile("[a-z][a-z0-9_-]*")
"""Names of benches: Zenoh would take others for patterns, and commands would go to all that fit."""
_STOP, _COMMAND = "/cmd/stop", re.compile("axis/[^/]+/(cmd|param|fault)/?|run/|segment/[^/]+/fault")
_SIGNS = {"connect_certificate", "connect_private_key"}
_FILES = {"root_ca_certificate", *_SIGNS}
_LATEST = 10_000
"""Maximum number of states that wait for a subscriber; the oldest of more are dropped."""


@dataclass(frozen=True)
class Credentials:
    """User and password at zenoh's door, with which commands are signed too."""

    user: str
    password: str

    def signed(self, key: str, payload: bytes, at_ns: int, nonce: str) -> bytes:
        """Sign a command."""
        return signed(self.user, self.password, key, payload, at_ns, nonce)


def priority_of(rest: str) -> zenoh.Priority:
    """Priority of a message on its way: a stop passes what waits, and a command the questions."""
    if rest.partition("?")[0].endswith(_STOP):
        return zenoh.Priority.REAL_TIME
    is_command = _COMMAND.match(rest) and not rest.endswith("/state")
    return zenoh.Priority.INTERACTIVE_HIGH if is_command else zenoh.Priority.DATA


def session_entries(endpoint: str, credentials: Credentials | None) -> dict[str, Any]:
    """Make zenoh's configuration of a client that knows one door and looks for no others."""
    entries: dict[str, Any] = {
        "mode": "client",
        "connect": {"endpoints": [endpoint]},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "transport": {"shared_memory": {"enabled": False}},
    }
    if credentials is not None:
        entries["transport"]["auth"] = {
            "usrpwd": {"user": credentials.user, "password": credentials.password}
        }
    return entries


def from_file(path: Path) -> tuple[dict[str, Any], str, Credentials | KeySigner | None]:
    """Read zenoh's configuration from a user's file, as `hil zenoh site` and `hil zenoh keys` make it.
    Names of certificates are relative to its folder.

    Raises:
        ClientError: it cannot be used.
    """
    try:
        values = json.loads(path.read_text("utf-8-sig"))
        tls = values.get("transport", {}).get("link", {}).get("tls", {})
        for name in _FILES & tls.keys():
            tls[name] = str(path.absolute().parent / tls[name])
        zenoh.Config.from_json5(json.dumps(values))
        door = ", ".join(values["connect"]["endpoints"])
        who = values.get("transport", {}).get("auth", {}).get("usrpwd")
        if who is None and tls.keys() >= _SIGNS:
            return values, door, _signer(values.get("metadata"), tls)
        return values, door, Credentials(who["user"], who["password"]) if who else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, zenoh.ZError) as error:
        why = getattr(error, "strerror", None) or error
        raise ClientError(f"{path}: {why}; `hil zenoh site` makes such files") from None


def _signer(metadata: Any, tls: Mapping[str, str]) -> KeySigner:
    """Signer by a user's key, in whose name commands are asked."""
    for name in sorted(_FILES):
        if not Path(tls[name]).is_file():
            raise ClientError(f"{tls[name]} is missing: the folder was copied in part; copy it again")
    certificate, key = Path(tls["connect_certificate"]), Path(tls["connect_private_key"])
    return signer_of_files(metadata["name"], certificate, key, ClientError)


class Link:
    """Session with one bench, which is open.

    Raises:
        ClientError: nobody lets it in there, or the bench is not behind that door.
    """

    def __init__(
        self,
        bench: str,
        endpoint: str,
        credentials: Credentials | None,
        config_file: Path | None,
        timeout_s: float,
    ) -> None:
        if not BENCH_NAME.fullmatch(bench):
            raise ClientError(f"{bench!r} is no name of a bench; it begins with a letter, as in demo")
        self.bench = bench
        self._timeout_s = timeout_s
        if config_file is not None:
            entries, door, self._credentials = from_file(config_file)
        else:
            entries = session_entries(endpoint, credentials)
            door, self._credentials = endpoint, credentials
        self._session = opened(entries, timeout_s)
        try:
            self._find(door)
        except BaseException:
            self.close()
            raise

    def _find(self, door: str) -> None:
        """Check that the bench is there; a router needs a moment to hear of it."""
        deadline_s = time.monotonic() + min(self._timeout_s, AWAY_S)
        while not self._tokens(self.key("@live/daemon")):
            if time.monotonic() > deadline_s:
                there = ", ".join(sorted({key.split("/")[1] for key in self._tokens("hil/*/@live/daemon")}))
                raise ClientError(
                    f"{door}: there is no bench {self.bench!r} that you may see; there: {there or 'none'}."
                    " Start it, or correct its name"
                )
            time.sleep(_LOOK_AGAIN_S)
        if (count := len(set(self._tokens(self.key("@one/*"))))) > 1:
            raise ClientError(
                f"{door}: {count} benches are called {self.bench!r} there; end all but one, or rename them"
            )

    def _tokens(self, key: str) -> list[str]:
        """Liveliness tokens that are there now and that we may see."""
        replies = self._session.liveliness().get(key, timeout=self._timeout_s)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok]

    def close(self) -> None:
        session: Any = self._session
        session.close()

    def key(self, rest: str) -> str:
        """Full key of this bench for ``rest``."""
        return f"hil/{self.bench}/{rest}"

    def ask(self, rest: str, payload: object = None, *, timeout_s: float | None = None) -> list[bytes]:
        """Send a query; answers its replies.

        Raises:
            CommandError: it was refused.
            ClientError: there was none in time.
        """
        text = "" if payload is None else json.dumps(payload)
        return self.ask_text(rest, text, timeout_s=timeout_s)

    def ask_text(self, rest: str, payload: str, *, timeout_s: float | None = None) -> list[bytes]:
        """Send a query with the payload as it is; answers its replies."""
        key, text = self.key(rest), payload.encode()
        if len(text) > MESSAGE_BYTES:
            raise ClientError(f"{key}: {len(text)} bytes; a message has at most {MESSAGE_BYTES}")
        waits_s = self._timeout_s if timeout_s is None else timeout_s
        replies = self._session.get(
            key,
            payload=text or None,
            attachment=self._signature(key.partition("?")[0], text),
            encoding=zenoh.Encoding.APPLICATION_JSON,
            consolidation=zenoh.ConsolidationMode.NONE,
            priority=priority_of(rest),
            timeout=waits_s,
        )
        answers = []
        for reply in replies:
            if reply.ok is not None:
                answers.append(reply.ok.payload.to_bytes())
            elif reply.err is not None:
                refusal = reply.err.payload.to_bytes()
                if not refusal.startswith(b"{"):
                    raise ClientError(f"{key}: {refusal.decode(errors='replace')} after {waits_s:g} s")
                raise error_of(refusal)
        if not answers:
            raise ClientError(
                f"{key}: nobody answers; is bench {self.bench} there, and does your role let you do this?"
            )
        return answers

    def do(self, device: str, verb: str, given: Mapping[str, object], wait: bool, timeout_s: float) -> Ack:
        """Carry out a verb; ``wait``: until the motion has ended, whose state is then in the answer."""
        if not wait:
            return ack_of(self.ask(f"axis/{device}/cmd/{verb}", dict(given))[0])
        replies = self.ask(f"axis/{device}/cmd/{verb}?done=true", dict(given), timeout_s=timeout_s)
        last = ack_of(replies[-1])
        if not last.answer.get("done"):
            raise ClientError(f"{device} was still moving after {timeout_s:g} s")
        first = ack_of(replies[0])
        return Ack(first.effective_at_ns, last.sim_ns, last.wall_ns, {**first.answer, **last.answer})

    def put(self, rest: str, payload: object) -> None:
        """Publish a command without an answer."""
        key, text = self.key(rest), json.dumps(payload).encode()
        self._session.put(
            key,
            text,
            attachment=self._signature(key, text),
            encoding=zenoh.Encoding.APPLICATION_JSON,
            priority=priority_of(rest),
            express=True,
        )

    def read(self, rest: str) -> dict[str, Any]:
        return read(self.ask(rest)[0])

    def subscribe(self, rest: str, call: Callable[[bytes], object] | None = None) -> Any:
        """Subscribe to a key: a subscriber whose ``recv`` blocks, or one that calls from its own thread."""
        if call is None:
            return self._session.declare_subscriber(self.key(rest), zenoh.handlers.RingChannel(_LATEST))
        return self._session.declare_subscriber(
            self.key(rest), lambda sample: call(sample.payload.to_bytes())
        )

    def alive(self) -> list[str]:
        """Names of what is alive: ``daemon``, ``axis/m1``, ``segment/bus0``."""
        head = self.key("@live/")
        return sorted(key.removeprefix(head) for key in self._tokens(f"{head}**"))

    def _signature(self, key: str, payload: bytes) -> bytes | None:
        if self._credentials is None:
            return None
        who = self._credentials
        return who.signed(key, payload, time.time_ns(), secrets.token_hex(8))
