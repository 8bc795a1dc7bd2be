"""Signatures of commands: the transport does not tell the sender, so each command carries proof.

An attachment is JSON: ``user``, ``at_ns`` (wall), ``nonce`` and ``mac``, the hexadecimal HMAC-SHA256 with the
user's password over key, at_ns, nonce and payload, with a line feed between them.
"""

import hmac
import json


def mac_of(secret: str, key: str, payload: bytes, at_ns: int, nonce: str) -> str:
    """Compute the ``mac`` of a command."""
    message = f"{key}\n{at_ns}\n{nonce}\n".encode() + payload
    return hmac.new(secret.encode(), message, "sha256").hexdigest()


def signed(user: str, secret: str, key: str, payload: bytes, at_ns: int, nonce: str) -> bytes:
    """Make the attachment of a command."""
    mac = mac_of(secret, key, payload, at_ns, nonce)
    return json.dumps({"user": user, "at_ns": at_ns, "nonce": nonce, "mac": mac}).encode()
