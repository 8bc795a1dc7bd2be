"""Reason why a TLS door stays shut, by a handshake of our own: zenoh says of all that it cannot connect."""

import re
import socket
import ssl
from pathlib import Path
from typing import NamedTuple

TRY_S = 1.0
_TLS = re.compile(r"tls/(?:\[(?P<v6>[^\]]+)\]|(?P<host>[^:/?#]+)):(?P<port>\d{1,5})(?:[?#].*)?")
_THEIRS = {
    9: "is not valid yet by this computer's clock; compare the clocks",
    10: "has expired; renew it there",
    62: "is not for the name {host}; connect to a name that is in it",
    64: "is not for the address {host}; connect to an address or a name that is in it",
}
"""Words for what OpenSSL finds wrong with the other's certificate, by its numbers (X509_V_ERR_*)."""
_OTHER = "it is from another authority: this is another site's door"
_OURS = {
    "UNKNOWN_CA": _OTHER,
    "DECRYPT_ERROR": _OTHER,  # of one with the same name
    "CERTIFICATE_EXPIRED": "it has expired, or is not valid yet, by the clock there; renew it, or"
    " compare the clocks",
    "CERTIFICATE_REQUIRED": "it wants one, and got none; connect with the folder of a member of the site",
    "CERTIFICATE_REVOKED": "it is revoked",
}
"""Words for what the other end finds wrong with our certificate, by a part of OpenSSL's name of its alert."""


class TlsFiles(NamedTuple):
    """Certificates of whom one trusts, one's own, and its key."""

    ca: Path
    certificate: Path
    key: Path


def why_shut(endpoint: str, files: TlsFiles | None, timeout_s: float = TRY_S) -> str:
    """Reason why a TLS handshake at zenoh's endpoint, as ``tls/hub.lan:7447``, does not end well; empty:
    nobody listens there, or TLS is not the reason. ``files``: None to come without a certificate. It
    blocks."""
    found = _TLS.fullmatch(endpoint)
    if not found:
        return ""
    host = found["v6"] or found["host"]
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    try:
        if files:
            context.load_verify_locations(files.ca)
            context.load_cert_chain(files.certificate, files.key)
        else:
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        with (
            socket.create_connection((host, int(found["port"])), timeout_s) as plain,
            context.wrap_socket(plain, server_hostname=host) as wrapped,
        ):
            wrapped.recv(1)  # with TLS 1.3 a refusal of our certificate comes behind the handshake
    except ssl.SSLCertVerificationError as error:
        fault = _THEIRS.get(error.verify_code, "is from another authority: it is another site's door")
        return f"the certificate of {endpoint} {fault.format(host=host)}"
    except ssl.SSLError as error:
        reason = error.reason or ""
        words = next((words for name, words in _OURS.items() if name in reason), "")
        return f"{endpoint} refuses our certificate: {words}" if words else ""
    except (OSError, ValueError):
        return ""
    return ""
