"""Gate for commands, which checks signatures (``hil.net.signature``): zenoh tells nothing about senders."""

import heapq
import hmac
import re
import secrets
import time
from collections.abc import Sequence, Set
from typing import NamedTuple

from bridges.zenoh.users import User
from hil.net.signature import mac_of, signed
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import JsonError, read_json

FRESH_NS = 30_000_000_000
"""Maximum difference between a signature's time and the daemon's: clocks of a site differ by seconds."""
REMEMBERED = 65_536
"""Maximum number of nonces kept of one user: 2000 commands a second for as long as a signature is fresh."""
ATTACHMENT_BYTES = 4096
"""Maximum length of an attachment: a certificate has 400 to 1400 bytes, a third more as base64."""
_NONCE = re.compile(r"[0-9a-f]{16,64}")
_MAC = re.compile(r"[0-9a-f]{64}")
_BASE64 = re.compile(r"(?:[A-Za-z0-9+/]{4})*(?:[A-Za-z0-9+/]{2}==|[A-Za-z0-9+/]{3}=)?")


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


class Signature(NamedTuple):
    """Content of an attachment; ``certificate`` is empty where a password signed."""

    user: str
    at_ns: int
    nonce: str
    signature: str
    certificate: str = ""


class Gate:
    """Checks the senders of commands, users of a file. ``since_ns``: older signatures are refused, as
    nonces are forgotten."""

    def __init__(self, users: Sequence[User], since_ns: int = 0) -> None:
        self._since_ns = since_ns
        self._users = {user.name: user for user in users}
        self._seen: dict[str, _Seen] = {}

    @property
    def names(self) -> Set[str]:
        """Names of the users."""
        return self._users.keys()

    def signed(self, source: Source, bench: str, key: str, payload: bytes) -> bytes:
        """Make an attachment as the asker, at the control socket the process's user; where the bench has no
        such user, as the user of the bench's name.

        Raises:
            VerbRefused: there is no such user.
        """
        for name in (source.name, source.person, bench):
            if name in self._users:
                at_ns, nonce = time.time_ns(), secrets.token_hex(8)
                return signed(name, self._users[name].secret, key, payload, at_ns, nonce)
        raise VerbRefused(
            "forbidden", f"no user {bench!r} to ask other benches as; add {bench}:operator:PASSWORD"
        )

    def check(self, attachment: bytes | None, key: str, payload: bytes, now_ns: int) -> User:
        """Check a signature; answers the user who signed the command. ``now_ns`` is wall time.

        Raises:
            Rejected: nobody known did, or not just now, or it was here before.
        """
        given = _read_attachment(attachment)
        if "\n" in key:
            raise Rejected("the signature is wrong: check user, password, key and payload")
        user = self._user(given, key, payload, now_ns)
        at_ns = given.at_ns
        if abs(now_ns - at_ns) > FRESH_NS:
            off_s = (now_ns - at_ns) / 1e9
            how = f"{off_s:.1f} s old" if off_s > 0 else f"of {-off_s:.1f} s from now"
            raise Rejected(f"the signature is {how}; compare the clocks of both computers")
        if at_ns < self._since_ns:
            raise Rejected("the signature is from before the daemon's start; sign the command again")
        self._seen.setdefault(given.user, _Seen()).add(given.nonce, at_ns, now_ns)
        return user

    def _user(self, given: Signature, key: str, payload: bytes, now_ns: int) -> User:
        """User who signed. Raises Rejected: nobody known did."""
        if given.certificate:
            raise Rejected("the command is signed by a certificate's key; this bench knows users by password")
        user = self._users.get(given.user)
        # The work is the same for a name that does not exist, and so is the answer.
        expected = mac_of(user.secret if user else "", key, payload, given.at_ns, given.nonce)
        if not hmac.compare_digest(expected, given.signature) or user is None:
            raise Rejected("the signature is wrong: check user, password, key and payload")
        return user


def _read_attachment(attachment: bytes | None) -> Signature:
    if not attachment:
        raise Rejected(
            "the command is not signed: its attachment has to have user, at_ns, nonce and mac, or certificate"
            " and signature"
        )
    try:
        given = read_json(attachment) if len(attachment) <= ATTACHMENT_BYTES else None
    except JsonError:
        given = None
    match given:
        case {"user": str(name), "at_ns": int(at_ns), "nonce": str(nonce), "mac": str(mac)}:
            if _NONCE.fullmatch(nonce) and _MAC.fullmatch(mac) and 0 <= at_ns < 1 << 63:
                return Signature(name, at_ns, nonce, mac)
        case {
            "user": str(name),
            "at_ns": int(at_ns),
            "nonce": str(nonce),
            "certificate": str(certificate),
            "signature": str(signature),
        }:
            is_base64 = _BASE64.fullmatch(certificate) and _BASE64.fullmatch(signature)
            if is_base64 and _NONCE.fullmatch(nonce) and 0 <= at_ns < 1 << 63:
                return Signature(name, at_ns, nonce, signature, certificate)
    raise Rejected(
        'the attachment has to be {"user": NAME, "at_ns": WALL, "nonce": HEX, "mac": HEX}, or with'
        ' "certificate" and "signature" as base64 in the place of "mac"'
    )
