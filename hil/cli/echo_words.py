"""Words for the echo of an adapter."""

from collections.abc import Mapping


def echo_words(echo: Mapping[str, str | int]) -> str:
    """Say what is known of an adapter, and what came of it; of one without an echo the first alone."""
    said = f"echo: {echo['state']}"
    if echo["bytes"]:
        said += f", {echo['bytes']} bytes that came back were dropped"
    return f"{said}, {echo['collisions']} collisions" if echo["collisions"] else said
