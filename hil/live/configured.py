"""What the configuration says now."""

from hil.config import BenchConfig, Catalogue


class Configured:
    """The bench's configuration, and the catalogue that it was checked against. Only ``hil.live.apply``
    exchanges ``config``; whoever keeps it longer than a call has an old one after a reload."""

    def __init__(self, config: BenchConfig, catalogue: Catalogue) -> None:
        self.config = config
        self.catalogue = catalogue
