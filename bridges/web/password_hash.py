"""Hashes of passwords: ``scrypt$14$8$5$SALT$HASH``, with the logarithm of its cost, block size, parallelism.

Source of the numbers: OWASP, "Password Storage Cheat Sheet", for 16 MB: the daemon's memory is locked.
"""

import hashlib
import hmac
from base64 import urlsafe_b64decode, urlsafe_b64encode
from binascii import Error

_SCHEME, _COST, _BLOCK, _TIMES = "scrypt", 14, 8, 5
_SALT_BYTES, _HASH_BYTES = 16, 32
_HEAD = f"{_SCHEME}${_COST}${_BLOCK}${_TIMES}$"


def hash_of(password: str, salt: bytes) -> str:
    """Hash a password, in 0.2 s. ``salt``: 16 random bytes."""
    return f"{_HEAD}{_text(salt)}${_text(_scrypt(password, salt))}"


def is_hash(text: str) -> bool:
    """True if a text has the form of ``hash_of``."""
    return _parts(text) is not None


def fits(password: str, text: str) -> bool:
    """True if a password has this hash; takes the same time if it has not. Raises ValueError: it is none."""
    if (parts := _parts(text)) is None:
        raise ValueError("no hash of a password")
    salt, expected = parts
    return hmac.compare_digest(_scrypt(password, salt), expected)


def _scrypt(password: str, salt: bytes) -> bytes:
    return hashlib.scrypt(
        password.encode("utf-8", "surrogatepass"),
        salt=salt,
        n=1 << _COST,
        r=_BLOCK,
        p=_TIMES,
        dklen=_HASH_BYTES,
    )


def _text(data: bytes) -> str:
    return urlsafe_b64encode(data).decode().rstrip("=")


def _parts(text: str) -> tuple[bytes, bytes] | None:
    if not text.startswith(_HEAD) or not text.isascii():
        return None
    salt, _, digest = text.removeprefix(_HEAD).partition("$")
    try:
        found = urlsafe_b64decode(salt + "=="), urlsafe_b64decode(digest + "=")
    except (Error, ValueError):
        return None
    return found if (len(found[0]), len(found[1])) == (_SALT_BYTES, _HASH_BYTES) else None
