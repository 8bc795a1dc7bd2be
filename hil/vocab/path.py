"""Paths of a set-point: pieces of constant jerk, one after the other."""

from typing import NamedTuple

from hil.vocab.time import NS_PER_S

DEG_PER_S = 6.0
"""One rpm in degrees per second."""


class PathPiece(NamedTuple):
    """Set-point and its first three derivatives by the second, at the beginning of ``duration_ns``."""

    duration_ns: int
    r: float
    per_s: float = 0.0
    per_s2: float = 0.0
    per_s3: float = 0.0

    def after(self, into_ns: int) -> tuple[float, float]:
        """Set-point and rate, ``into_ns`` after the beginning."""
        t = into_ns / NS_PER_S
        r = self.r + t * (self.per_s + t * (self.per_s2 / 2 + t * self.per_s3 / 6))
        return r, self.per_s + t * (self.per_s2 + t * self.per_s3 / 2)


Path = tuple[PathPiece, ...]
