"""Signatures of commands: the transport does not tell the sender, so each command carries proof.

An attachment is JSON, in one of two forms. Both sign the same text: key, ``at_ns`` and ``nonce`` with a
line feed behind each, then the payload's bytes. The key is that of the message, without ``?`` and what
follows; ``at_ns`` is wall time in nanoseconds since 1970, as decimal digits; ``nonce`` is 16 to 64
hexadecimal digits by chance.

By password (``users:``): ``user``, ``at_ns``, ``nonce`` and ``mac``, the hexadecimal HMAC-SHA256 of the
text with the user's password.

By key (``site:``): ``user``, ``at_ns``, ``nonce``, ``certificate``, the sender's certificate as base64 of
its DER, and ``signature``, base64 of the DER of an ECDSA signature with SHA-256 and the certificate's key
(P-256). Before the text stand ``user`` and a line feed. ``user`` is the sender's name in the site's list;
a bench that asks another for a user, with a part of a run, gives that user's name with its own certificate.
"""

import base64
import hmac
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

NO_CRYPTOGRAPHY = "certificates need the package cryptography: pip install 'hil-motion[site]'"


def text_of(key: str, payload: bytes, at_ns: int, nonce: str) -> bytes:
    """Text that is signed."""
    return f"{key}\n{at_ns}\n{nonce}\n".encode() + payload


def mac_of(secret: str, key: str, payload: bytes, at_ns: int, nonce: str) -> str:
    """Compute the ``mac`` of a command."""
    return hmac.new(secret.encode(), text_of(key, payload, at_ns, nonce), "sha256").hexdigest()


def signed(user: str, secret: str, key: str, payload: bytes, at_ns: int, nonce: str) -> bytes:
    """Make the attachment of a command, by password."""
    mac = mac_of(secret, key, payload, at_ns, nonce)
    return json.dumps({"user": user, "at_ns": at_ns, "nonce": nonce, "mac": mac}).encode()


class KeySigner:
    """Signs commands with the key of a certificate. ``user``: name of its owner."""

    def __init__(self, user: str, certificate: "Certificate", private_key: Any) -> None:
        from cryptography.hazmat.primitives import hashes
        from cryptography.hazmat.primitives.asymmetric import ec
        from cryptography.hazmat.primitives.serialization import Encoding

        self.user = user
        self._key, self._how = private_key, ec.ECDSA(hashes.SHA256())
        self._certificate = base64.b64encode(certificate.public_bytes(Encoding.DER)).decode()

    def signed(self, key: str, payload: bytes, at_ns: int, nonce: str, user: str = "") -> bytes:
        """Make the attachment of a command. ``user``: for whom a bench asks; by default the owner."""
        name = user or self.user
        signature = self._key.sign(f"{name}\n".encode() + text_of(key, payload, at_ns, nonce), self._how)
        return json.dumps(
            {
                "user": name,
                "at_ns": at_ns,
                "nonce": nonce,
                "certificate": self._certificate,
                "signature": base64.b64encode(signature).decode(),
            }
        ).encode()


def is_by_key(public_key: Any, signature: bytes, text: bytes) -> bool:
    """True if a P-256 key made an ECDSA signature of a text."""
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec

    if not isinstance(public_key, ec.EllipticCurvePublicKey):
        return False
    try:
        public_key.verify(signature, text, ec.ECDSA(hashes.SHA256()))
    except InvalidSignature:
        return False
    return True


def read_key(pem: bytes, is_private: bool, where: str, error: type[Exception] = ValueError) -> Any:
    """Read a key of P-256. ``where`` stands before a problem; ``error`` is raised with it."""
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import load_pem_private_key, load_pem_public_key

    try:
        key: Any = load_pem_private_key(pem, None) if is_private else load_pem_public_key(pem)
    except TypeError:
        raise error(
            f"{where}: the key has a password, which a daemon cannot give; store it without"
        ) from None
    except (ValueError, UnsupportedAlgorithm):
        kind = "private key" if is_private else "public key"
        raise error(f"{where}: there is no {kind} in it (PEM); copy it again") from None
    if not isinstance(getattr(key, "curve", None), ec.SECP256R1):
        raise error(f"{where}: it is a key of another kind; sites use EC keys of P-256 (prime256v1)")
    return key


def signer_of_files(user: str, certificate: Path, key: Path, error: type[Exception]) -> KeySigner:
    """Signer of a user by the files of certificate and key. ``error`` is raised with what is wrong with
    them."""
    try:
        from cryptography.x509 import load_pem_x509_certificate
    except ImportError:
        raise error(NO_CRYPTOGRAPHY) from None
    if (mode := key.stat().st_mode & 0o777) & 0o077:
        raise error(f"{key}: others can read this key (mode {mode:04o}); chmod 600 {key}")
    private = read_key(key.read_bytes(), True, str(key), error)
    try:
        own = load_pem_x509_certificate(certificate.read_bytes())
    except ValueError:
        raise error(f"{certificate}: there is no certificate in it (PEM); copy it again") from None
    if own.public_key() != private.public_key():
        raise error(f"{key} is not the key of {certificate}; copy both again")
    return KeySigner(user, own, private)
