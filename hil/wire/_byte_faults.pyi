from typing_extensions import Buffer

class Draws:
    """Draws of chance. ``seed``: the state to start from; ``flip`` to ``delay``: how many of 2**64 draws hit,
    up to all."""

    def __init__(
        self, seed: int, flip: int, drop: int, duplicate: int, delay: int, delay_ns: int
    ) -> None: ...
    @property
    def changed_bytes(self) -> int: ...
    def apply(self, data: Buffer) -> list[tuple[int, bytes]]: ...
