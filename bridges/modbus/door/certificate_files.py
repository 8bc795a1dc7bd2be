"""Files of the door's TLS: what is wrong with them, and the context that they make."""

import ssl
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

_PEM_MARK = b"-----BEGIN "
_ENCRYPTED = b"ENCRYPTED"
"""Mark of a key with a password: ``-----BEGIN ENCRYPTED PRIVATE KEY-----`` (RFC 7468, 11), or
``Proc-Type: 4,ENCRYPTED`` (RFC 1421, 4.6.1.1)."""


class CertificateFiles(NamedTuple):
    """Files in PEM: the door's certificate with those between it and its authority, its private key, and the
    authority that clients' certificates are from."""

    certificate: Path
    key: Path
    clients: Path


class FileProblem(NamedTuple):
    """Mistake in a file. ``option``: which file; ``message`` names it."""

    option: str
    message: str
    remedy: str


def problems(files: CertificateFiles) -> Iterator[FileProblem]:
    """Find what is wrong with files: one mistake of each."""
    found = {
        option: problem for option, path in files._asdict().items() if (problem := _unusable(option, path))
    }
    for option in ("certificate", "clients"):
        if option not in found and not _has_certificates(path := getattr(files, option)):
            remedy = "write where a certificate in PEM is"
            found[option] = FileProblem(option, f"{path.absolute()} has no certificate", remedy)
    if not found.keys() & {"certificate", "key"} and (why := _no_pair(files)):
        found["key"] = FileProblem("key", *why)
    yield from found.values()


def context(files: CertificateFiles) -> ssl.SSLContext:
    """Make the TLS of the door: certificates both ways. Raises OSError, ValueError: as ``problems`` tells."""
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    made.minimum_version = ssl.TLSVersion.TLSv1_2
    made.verify_mode = ssl.CERT_REQUIRED
    made.load_cert_chain(files.certificate, files.key, password="")  # with none it would ask at the terminal
    made.load_verify_locations(files.clients)
    return made


def _unusable(option: str, path: Path) -> FileProblem | None:
    """Mistake of a file that cannot be read, or is not PEM."""
    at = path.absolute()
    try:
        if not path.exists():
            return FileProblem(option, f"{at} is not there", "write where the file is")
        if not path.is_file():  # of a fifo a read would not end
            return FileProblem(option, f"{at} is no file", "write where the file is")
        text = path.read_bytes()
    except OSError as error:
        remedy = "let the user who serves the bench read it"
        return FileProblem(option, f"{at} cannot be read: {error.strerror}", remedy)
    if _PEM_MARK not in text:
        remedy = "a file in PEM has a line -----BEGIN ...; openssl converts others"
        return FileProblem(option, f"{at} is not PEM", remedy)
    return None


def _has_certificates(path: Path) -> bool:
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_verify_locations(path)
    except (OSError, ValueError):
        return False
    return True


def _no_pair(files: CertificateFiles) -> tuple[str, str] | None:
    """Message and remedy, if a certificate and a key are no pair."""
    key, certificate = files.key.absolute(), files.certificate.absolute()
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password="")
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            return f"{key} is not the key of {certificate}", "write where the key of that certificate is"
        if _ENCRYPTED in key.read_bytes():
            return f"{key} is locked with a password", "take it off: nobody is there to type it"
        return f"{key} has no private key", "write where the key is, in PEM"
    except (OSError, ValueError) as error:
        return f"{key} cannot be used: {error}", "write where the key is, in PEM"
    return None
