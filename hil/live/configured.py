"""What the configuration says now."""

from hil.config import BenchConfig, Catalogue


class Configured:
    """The bench's configuration, and the catalogue that it was checked against; a reload exchanges it."""

    def __init__(self, config: BenchConfig, catalogue: Catalogue) -> None:
        self.config = config
        self.catalogue = catalogue
