"""Text of files that other programs wrote: the one place that says which bytes are which characters.

A mark at the beginning (U+FEFF) says UTF-8 or UTF-16, and is no character of the text. Without one it is
UTF-8, and where it cannot be that, Windows' Western European (1252), in which older tools write.
"""

_MARKS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))


def text_of(data: bytes) -> str:
    """Decode the content of a file; every content is some text."""
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data[len(mark) :].decode(encoding, "replace")
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def lines_of(text: str) -> list[str]:
    """Lines without their ends, which are LF, CR with LF, or CR alone."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
