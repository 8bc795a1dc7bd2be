"""Session with all benches behind a door at once: their inventory, and questions that all are asked."""

import json
import secrets
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import zenoh

from hil.client.door import opened
from hil.client.link import BENCH_NAME, ENDPOINT, TIMEOUT_S, Credentials, from_file, session_entries
from hil.client.messages import ClientError, CommandError
from hil.net.signature import KeySigner
from hil.net.site_stop import TIMEOUT_S as STOP_S
from hil.net.site_stop import Row, stop_all
from hil.vocab.bench_labels import has_labels
from hil.wire.json_text import JsonError, read_json

ANSWER_S = 1.0
"""Time after which a bench that has not answered is silent."""
_SILENT = "it does not answer: its computer is away, or it stands still"
_OLDER = (
    "it tells nothing about itself: your role does not let you see it, or hil there is of an older version"
)


class LabAnswer(NamedTuple):
    """Answer of one bench to a question that all were asked. ``refusal``: code and text, in place of a
    content."""

    bench: str
    content: Mapping[str, Any]
    refusal: tuple[str, str] | None = None


class Lab:
    """Session at a door with benches behind it: a router, or a bench's own door.

    Raises:
        ClientError: nobody lets it in there; the text says why.
    """

    def __init__(
        self,
        endpoint: str | None = None,
        *,
        credentials: Credentials | None = None,
        config: str | Path | None = None,
        timeout_s: float = TIMEOUT_S,
    ) -> None:
        self._credentials: Credentials | KeySigner | None
        if config is None:
            entries = session_entries(endpoint or ENDPOINT, credentials)
            self.door, self._credentials = endpoint or ENDPOINT, credentials
        else:
            entries, self.door, self._credentials = from_file(Path(config))
            if endpoint:
                entries["connect"] = {"endpoints": [endpoint]}
                self.door = endpoint
        self.session = opened(entries, timeout_s)

    def __enter__(self) -> "Lab":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        session: Any = self.session
        session.close()

    def stop(self, how: str = "grace", *, answer_s: float = STOP_S) -> list[Row]:
        """Stop all that moves on all benches; answers a row for each that is there. ``how``: "grace" or
        "prejudice"."""
        who = self._credentials

        def sign(key: str, payload: bytes) -> bytes | None:
            return who.signed(key, payload, time.time_ns(), secrets.token_hex(8)) if who else None

        return stop_all(self.session, sign, how, answer_s)

    def ask_all(
        self, rest: str, payload: object = None, *, answer_s: float = ANSWER_S
    ) -> tuple[list[LabAnswer], bool]:
        """Ask all benches one question under ``hil/*/<rest>``, signed if there are credentials. Answers what
        came, and whether some were silent until the time was over."""
        return self._asked(rest, payload, answer_s)()

    def ask(
        self, bench: str, rest: str, payload: object = None, *, answer_s: float = ANSWER_S
    ) -> Mapping[str, Any]:
        """Ask one bench under ``hil/<bench>/<rest>``, signed if there are credentials; answers the document.

        Raises:
            CommandError: it was refused.
            ClientError: nobody answers, or two benches have this name.
        """
        if not BENCH_NAME.fullmatch(bench):
            raise ClientError(f"{bench!r} is no name of a bench; it begins with a letter, as in demo")
        answers, _ = self._asked(rest, payload, answer_s, bench)()
        if len(answers) > 1:
            raise ClientError(f"{self.door}: {len(answers)} benches are called {bench!r}; end all but one")
        if not answers:
            raise ClientError(
                f"{self.door}: nobody answers for the bench {bench!r}: it is not there, or your role does not"
                " let you do this; `hil list --joined` lists who is there"
            )
        if answers[0].refusal:
            raise CommandError(*answers[0].refusal)
        return answers[0].content

    def _asked(
        self, rest: str, payload: object, answer_s: float, bench: str = "*"
    ) -> Callable[[], tuple[list[LabAnswer], bool]]:
        """Ask; answers a function that waits for the answers."""
        key, text = f"hil/{bench}/{rest}", b"" if payload is None else json.dumps(payload).encode()
        who, attachment = self._credentials, None
        if who is not None:
            attachment = who.signed(key, text, time.time_ns(), secrets.token_hex(8))
        replies = self.session.get(
            key,
            payload=text or None,
            attachment=attachment,
            encoding=zenoh.Encoding.APPLICATION_JSON,
            consolidation=zenoh.ConsolidationMode.NONE,
            target=zenoh.QueryTarget.ALL,
            timeout=answer_s,
        )

        def answers() -> tuple[list[LabAnswer], bool]:
            found, is_late = [], False
            for reply in replies:
                if reply.ok is not None:
                    name = str(reply.ok.key_expr).split("/")[1]
                    found.append(LabAnswer(name, _object(reply.ok.payload.to_bytes())))
                elif reply.err is not None:
                    told = _object(reply.err.payload.to_bytes())
                    if not told:  # zenoh's own word on a question without an answer
                        is_late = True
                        continue
                    name = "".join(str(told.get("key", "")).split("/")[1:2])
                    found.append(LabAnswer(name, {}, (str(told.get("code")), str(told.get("error")))))
            return found, is_late

        return answers

    def benches(
        self, labels: Mapping[str, str] | None = None, *, answer_s: float = ANSWER_S
    ) -> list[dict[str, Any]]:
        """List the benches by name: the content of each one's key ``about``, with ``why``, a text about what
        is wrong with it as one of a lab, or None. ``labels``: those alone that have all of these.

        A bench of an older version, or one that is silent, has what its liveliness tells: ``bench``,
        ``devices``, ``why``.
        """
        told = self._asked("about", None, answer_s)
        alive = self._tokens("hil/*/@live/daemon", answer_s)
        answers, is_late = told()
        rows = [dict(answer.content) for answer in answers if answer.content.get("bench") == answer.bench]
        counts = Counter(row["bench"] for row in rows)
        for row in rows:
            same = counts[row["bench"]]
            row["why"] = f"{same} benches have this name: end all but one" if same > 1 else None
        for name in sorted({key.split("/")[1] for key in alive()} - counts.keys()):
            axes = self._tokens(f"hil/{name}/@live/axis/*", answer_s)()
            devices: dict[str, Any] = {key.split("/")[4]: {} for key in axes}
            rows.append({"bench": name, "devices": devices, "why": _SILENT if is_late else _OLDER})
        chosen = [row for row in rows if has_labels(row.get("labels", {}), labels or {})]
        return sorted(chosen, key=lambda row: (row["bench"], str(row.get("host"))))

    def _tokens(self, key: str, answer_s: float) -> Callable[[], list[str]]:
        """Ask for liveliness tokens; answers a function that waits for them."""
        replies = self.session.liveliness().get(key, timeout=answer_s)
        return lambda: [str(reply.ok.key_expr) for reply in replies if reply.ok]


def _object(text: bytes) -> dict[str, Any]:
    """Content of an answer; empty for what is none of a bench."""
    try:
        content = read_json(text)
    except JsonError:
        return {}
    return content if isinstance(content, dict) else {}
