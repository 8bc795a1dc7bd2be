"""Addresses of real ports and drives: their forms, and the keys behind the ``?``."""

from collections.abc import Iterator, Sequence

SERIAL_URLS = ("socket://", "rfc2217://")
SERIAL_FORMS = "write a path as in /dev/ttyUSB0, socket://host:port or rfc2217://host:port"


def is_serial_address(text: str) -> bool:
    """Say whether a text can name a real serial port: a device node's path, or a URL of ``SERIAL_URLS``."""
    kind = next((kind for kind in SERIAL_URLS if text.startswith(kind)), None)
    if kind is None:
        return text.startswith("/") and "\0" not in text
    host, colon, number = text.removeprefix(kind).partition("?")[0].rpartition(":")
    return bool(host and colon) and number.isdigit() and 0 < int(number) < 65536


class AddressRefused(Exception):
    """Refusal of an address: ``str(error)`` says what is wrong, ``remedy`` what to write."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.remedy = remedy


def query_keys(query: str, known: Sequence[str], example: str) -> Iterator[tuple[str, str]]:
    """Keys and values of a query, each key once. Raises AddressRefused."""
    seen = set()
    for item in query.split("&") if query else ():
        key, equals, value = item.partition("=")
        if not equals:
            raise AddressRefused("the part after ? is not of the form key=value", f"write {example}")
        if key not in known:
            known_are = f"known are: {', '.join(known)}"
            raise AddressRefused(f"there is no {key[:20]!r} in this address", known_are)
        if key in seen:
            raise AddressRefused(f"{key} is there twice", "leave one of them out")
        seen.add(key)
        yield key, value


def with_key(text: str, key: str, value: int) -> str:
    """Address with one key more."""
    return f"{text}{'&' if '?' in text else '?'}{key}={value}"


def whole_number(text: str) -> int | None:
    """Whole number from 0 on, of at most 9 digits; None: a text is none."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else None
