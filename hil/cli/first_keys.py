"""Words for what a user types first: a board that has started says nothing by itself."""


def first_keys(greeting: str) -> str:
    """Words for what to type to see something of a board that answers ``greeting``; empty without one."""
    typed = greeting.rstrip("\r\n")
    parts = [f"type {typed if typed.isprintable() else ascii(typed)}"] if typed else []
    if greeting != typed:
        parts.append("press Enter")
    return " and ".join(parts)
