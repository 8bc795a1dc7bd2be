"""Doors for other protocols: one folder for each, found by its name when a configuration names it.

Each folder has a ``bridge.py`` with ``Options`` (a strict pydantic model), ``make(options, host) -> Bridge``
and ``reference() -> str``, its section of the reference. A bridge knows no board by name.

Each may import: hil.net, hil.vocab, hil.wire, the standard library, any package.
"""
