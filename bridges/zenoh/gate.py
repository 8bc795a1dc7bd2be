"""Gate for commands, which checks signatures (``hil.net.signature``): zenoh tells nothing about senders."""

import heapq
import hmac
import re
from collections.abc import Sequence

from bridges.zenoh.users import User
from hil.net.signature import mac_of
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import JsonError, read_json

FRESH_NS = 30_000_000_000
"""Maximum difference between a signature's time and the daemon's: clocks of a site differ by seconds."""
REMEMBERED = 65_536
"""Maximum number of nonces kept of one user: 2000 commands a second for as long as a signature is fresh."""
ATTACHMENT_BYTES = 1024
_NONCE = re.compile(r"[0-9a-f]{16,64}")
_MAC = re.compile(r"[0-9a-f]{64}")


class Rejected(VerbRefused):
    """Refusal of a command whose signature does not do."""

    def __init__(self, why: str) -> None:
        super().__init__("forbidden", why)


class _Seen:
    """Nonces of one user. Where there are too many, the oldest goes, and whatever is as old is refused."""

    def __init__(self) -> None:
        self._nonces: set[str] = set()
        self._by_time: list[tuple[int, str]] = []
        self._floor_ns = 0

    def add(self, nonce: str, at_ns: int, now_ns: int) -> None:
        if nonce in self._nonces or at_ns <= self._floor_ns:
            raise Rejected("the signature was used before: sign each command again")
        while self._by_time and (self._by_time[0][0] < now_ns - FRESH_NS or len(self._by_time) >= REMEMBERED):
            gone_ns, gone = heapq.heappop(self._by_time)
            self._floor_ns = max(self._floor_ns, gone_ns)
            self._nonces.discard(gone)
        self._nonces.add(nonce)
        heapq.heappush(self._by_time, (at_ns, nonce))


class Gate:
    """Checks the senders of commands. ``since_ns``: older signatures are refused, as nonces are forgotten."""

    def __init__(self, users: Sequence[User], since_ns: int = 0) -> None:
        self._since_ns = since_ns
        self._users = {user.name: user for user in users}
        self._seen = {user.name: _Seen() for user in users}

    @property
    def names(self) -> frozenset[str]:
        """Names of the users."""
        return frozenset(self._users)

    def secret_of(self, name: str) -> str | None:
        """Secret of a user, to sign with; None: there is no such user."""
        return self._users[name].secret if name in self._users else None

    def check(self, attachment: bytes | None, key: str, payload: bytes, now_ns: int) -> User:
        """Check a signature; answers the user who signed the command. ``now_ns`` is wall time.

        Raises:
            Rejected: nobody known did, or not just now, or it was here before.
        """
        name, at_ns, nonce, mac = _read_attachment(attachment)
        user = self._users.get(name)
        # The work is the same for a name that does not exist, and so is the answer.
        expected = mac_of(user.secret if user else "", key, payload, at_ns, nonce)
        if not hmac.compare_digest(expected, mac) or user is None or "\n" in key:
            raise Rejected("the signature is wrong: check user, password, key and payload")
        if abs(now_ns - at_ns) > FRESH_NS:
            off_s = (now_ns - at_ns) / 1e9
            how = f"{off_s:.1f} s old" if off_s > 0 else f"of {-off_s:.1f} s from now"
            raise Rejected(f"the signature is {how}; compare the clocks of both computers")
        if at_ns < self._since_ns:
            raise Rejected("the signature is from before the daemon's start; sign the command again")
        self._seen[name].add(nonce, at_ns, now_ns)
        return user


def _read_attachment(attachment: bytes | None) -> tuple[str, int, str, str]:
    if not attachment:
        raise Rejected("the command is not signed: its attachment has to have user, at_ns, nonce and mac")
    try:
        given = read_json(attachment) if len(attachment) <= ATTACHMENT_BYTES else None
    except JsonError:
        given = None
    match given:
        case {"user": str(name), "at_ns": int(at_ns), "nonce": str(nonce), "mac": str(mac)}:
            if _NONCE.fullmatch(nonce) and _MAC.fullmatch(mac) and 0 <= at_ns < 1 << 63:
                return name, at_ns, nonce, mac
    raise Rejected('the attachment has to be {"user": NAME, "at_ns": WALL, "nonce": HEX, "mac": HEX}')
