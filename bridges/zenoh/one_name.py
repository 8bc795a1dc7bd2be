"""Names of benches: a bench joins only where nobody has its name, and notices when another one comes."""

import secrets
from typing import Any

import zenoh

from bridges.zenoh.keys import prefix
from hil.vocab.bridge_protocol import BenchProblem

ASK_S = 1.0
_REMEDY = "end one of them, or give it another name (`bench:`)"


def is_taken(session: zenoh.Session, bench: str) -> bool:
    """True if a bench of this name is joined; asked before this one is."""
    tokens = session.liveliness().get(f"{prefix(bench)}/@live/daemon", timeout=ASK_S)
    return any(token.ok for token in tokens)


def stands_aside(bench: str, where: str) -> BenchProblem:
    """Clash of a bench that does not join, as it came second."""
    what = f"another bench {bench} is joined at {where}; this one is not, and tries again each second"
    return BenchProblem(bench, what, _REMEDY)


class OneName:
    """Watch for others of a bench's name. Each bench has a token with a number of its own: tokens of one key
    cannot be told apart."""

    def __init__(self, session: zenoh.Session, bench: str) -> None:
        self._bench = bench
        head = f"{prefix(bench)}/@one"
        self._own = f"{head}/{secrets.token_hex(8)}"
        self._others: set[str] = set()
        live = session.liveliness()
        noted = zenoh.handlers.Callback(self._note, indirect=False)
        self.entities: list[Any] = [
            live.declare_token(self._own),
            live.declare_subscriber(f"{head}/*", noted, history=True),
        ]

    def _note(self, sample: zenoh.Sample) -> None:
        """Note a token, in a thread of zenoh."""
        key = str(sample.key_expr)
        if sample.kind == zenoh.SampleKind.DELETE:
            self._others.discard(key)
        elif key != self._own:
            self._others.add(key)

    @property
    def clash(self) -> BenchProblem | None:
        """Clash with others that are joined too; None: there are none."""
        if not (count := len(self._others)):
            return None
        what = f"{count} more joined as {self._bench}: commands, except stop, are refused here"
        return BenchProblem(self._bench, what, _REMEDY)
