"""The part of the reference about keys, written from their table."""

from bridges.zenoh.keys import KEYS


def reference() -> str:
    """The keys, as Markdown."""
    lines = [
        "## Keys of the zenoh bridge\n",
        "Below `hil/<bench>/`. JSON carries its version in `v`, its schema in the encoding, and the times at"
        " which it was written: `sim_ns`, and `wall_ns` since 1970. A command is put, and then nothing comes"
        " back, or queried, and then answered; a refusal is an error reply with a `code` (see Verbs of"
        " devices). A role is the least that may use the key, where the bench has users.\n",
        "| key | way | payload | schema | role | what | example |",
        "|---|---|---|---|---|---|---|",
    ]
    for key in KEYS:
        example = f"`{key.example}`" if key.example else ""
        cells = (f"`{key.pattern}`", ", ".join(key.way), key.payload, key.schema, key.role.name.lower())
        lines.append("| " + " | ".join((*cells, key.about, example)) + " |")
    return "\n".join(lines) + "\n"
