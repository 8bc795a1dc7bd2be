"""Present configuration of a bench."""

from dataclasses import dataclass

from hil.config import BenchConfig, Catalogue


@dataclass
class Configured:
    """Present configuration, and the catalogue that it was checked against. Only ``hil.live.apply``
    exchanges ``config``: a caller that keeps it longer than a call has an old one after a reload."""

    config: BenchConfig
    catalogue: Catalogue
