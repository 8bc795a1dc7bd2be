"""Words for what keeps a serial port from being opened: what is wrong, and what to do."""

import os
import re
from urllib.parse import urlsplit

_AS_URL = "as in socket://127.0.0.1:4001"
_ERRNO = re.compile(r"\[Errno -?\d+\] ([^\[\]]*?)'?$")
_KNOWN = (
    ("Connection refused", "nobody listens there; start what serves it, or correct the port"),
    ("Name or service not known", "there is no such computer; correct its name"),
    ("No address associated with hostname", "there is no such computer; correct its name"),
    (
        "Temporary failure in name resolution",
        "its name is not found; write its address instead",
    ),
    ("timed out", "it does not answer; look whether it is on, and reached from here"),
    ("No route to host", "there is no way to it; look at its address and the network"),
    ("Network is unreachable", "there is no way to it; look at its address and the network"),
    ("Resource temporarily unavailable", "another program has it open; close it there"),
    ("Device or resource busy", "another program has it open; close it there"),
    ("Inappropriate ioctl for device", "this is no serial port; write a path as in /dev/ttyUSB0"),
    ("Is a directory", "this is a folder; write a path as in /dev/ttyUSB0"),
)
"""Ends of what Linux says, and words for people."""


def url_problem(url: str) -> str:
    """Problem of the URL of a port behind a socket, with what to write; empty: there is none."""
    if "://" not in url:
        return ""
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        return f"its port is none of 1 to 65535; write {_scheme(url)}HOST:PORT, {_AS_URL}"
    if parts.scheme in ("socket", "rfc2217") and (not parts.hostname or not port):
        what = "computer" if not parts.hostname else "port"
        return f"it names no {what}; write {_scheme(url)}HOST:PORT, {_AS_URL}"
    return ""


def _scheme(url: str) -> str:
    return url.partition("://")[0] + "://"


def not_opened(url: str, error: Exception) -> str:
    """Reason why a port cannot be opened, and what to do. ``error``: of pyserial or the system."""
    if why := url_problem(url):
        return why
    number = getattr(error, "errno", None)
    said = os.strerror(number) if number and number > 0 else str(error)
    if "://" not in url and os.path.isfile(url):
        said = "Inappropriate ioctl for device"
    if found := _ERRNO.search(said):
        said = found[1]
    return next((words for end, words in _KNOWN if end in said), said)
