"""Files of the door's TLS: what is wrong with them, and the context that they make."""

import ssl
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple


class TlsProblem(NamedTuple):
    """Mistake in a file. ``option``: which file; ``message`` names it."""

    option: str
    message: str
    remedy: str


def context(certificate: Path, key: Path) -> ssl.SSLContext:
    """Make the TLS of the door. Raises OSError, ValueError: as ``file_problems`` tells."""
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    made.minimum_version = ssl.TLSVersion.TLSv1_2
    made.load_cert_chain(certificate, key, password="")  # with none it would ask at the terminal
    return made


def file_problems(certificate: Path, key: Path) -> Iterator[TlsProblem]:
    """Find what is wrong with the two files."""
    is_readable = True
    for option, path in (("certificate", certificate), ("key", key)):
        if why := _unreadable(path):
            is_readable = False
            yield TlsProblem(option, f"{path.absolute()} {why}", "write where the file is, in PEM")
    if not is_readable:
        return
    try:
        context(certificate, key)
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            message = f"{key.absolute()} is not the key of {certificate.absolute()}"
            yield TlsProblem("key", message, "write where the key of that certificate is")
        else:
            message = f"{certificate.absolute()} and {key.absolute()} are no certificate and its open key"
            yield TlsProblem(
                "certificate", message, "write where both are, in PEM, the key without a password"
            )
    except (OSError, ValueError) as error:
        yield TlsProblem("key", f"{key.absolute()} cannot be used: {error}", "write where the key is, in PEM")


def _unreadable(path: Path) -> str | None:
    try:
        if not path.exists():
            return "is not there"
        if not path.is_file():  # of a fifo a read would not end
            return "is no file"
        with path.open("rb"):
            return None
    except OSError as error:
        return f"cannot be read: {error.strerror}"
