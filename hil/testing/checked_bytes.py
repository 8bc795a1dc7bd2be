"""Bytes for ports: text and numbers are slips."""


def checked_bytes(data: bytes) -> bytes:
    """Copy what is to be written to a port, or is waited for at one.

    Raises:
        TypeError: it is text or a number, with what to give instead.
    """
    __tracebackhide__ = True
    if isinstance(data, (bytes, bytearray, memoryview)):
        return bytes(data)
    instead = repr(data.encode()) if isinstance(data, str) else "b'...'"
    raise TypeError(f"a port carries bytes: {instead}, not {data!r}")
