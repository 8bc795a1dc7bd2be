"""Names of real serial ports: a device node, or a URL as pyserial has them."""

SERIAL_URLS = ("socket://", "rfc2217://")
SERIAL_FORMS = "write a path as in /dev/ttyUSB0, socket://host:port or rfc2217://host:port"


def is_serial_address(text: str) -> bool:
    """Say whether a text can name a real serial port: a device node's path, or a URL of ``SERIAL_URLS``."""
    kind = next((kind for kind in SERIAL_URLS if text.startswith(kind)), None)
    if kind is None:
        return text.startswith("/") and "\0" not in text
    host, colon, number = text.removeprefix(kind).partition("?")[0].rpartition(":")
    return bool(host and colon) and number.isdigit() and 0 < int(number) < 65536
