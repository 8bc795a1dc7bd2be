"""Refusal of what one kind of bench cannot do, and another can."""

from typing import Any

RAISED: list[str] = []
"""Refusals so far, for who counts those that a test has passed over."""


class UnsupportedHere(Exception):
    """Error of a call that this kind of bench cannot carry out: ``str(error)`` says which kind, and why not.
    Pytest skips the test (``hil.testing.kind_account``)."""

    def __init__(self, kind: str, why: str) -> None:
        super().__init__(f"kind={kind}: {why}")
        self.kind = kind
        RAISED.append(str(self))


class RealTimeFace:
    """Face of a bench in real time, or of a part of one, for which the bench in memory has a face that can do
    more: what only that one can do is refused. ``kind``: of the bench, ``live`` or ``real``."""

    kind: str

    def _virtual(self) -> tuple[type, frozenset[str]]:
        """Class of the face that a bench in memory has, and the public attributes of its instances."""
        raise NotImplementedError

    def __getattr__(self, name: str) -> Any:
        __tracebackhide__ = True
        if not name.startswith("_"):
            face, attributes = self._virtual()
            if hasattr(face, name) or name in attributes:
                raise UnsupportedHere(self.kind, f"{name!r} is of a bench in memory alone (--hil=virtual)")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
