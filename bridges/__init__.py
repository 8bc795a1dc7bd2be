"""Bridges, doors of a bench for other protocols: one folder for each, found by its name when a configuration
names it.

Each folder has a ``bridge.py`` with ``Options`` (a strict pydantic model), ``reference()`` (its part of the
reference) and ``make(options, desk) -> Bridge``. What a bridge must have is
``hil.vocab.bridge_protocol.Bridge``. The desk (``hil.vocab.desk_protocol.Desk``) is all that it has of a
bench: through it a bridge asks for operations of the table, watches, and describes the bench. A bridge knows
no board by name. ``docs/how-to/add-a-bridge.md`` writes one.

Each may import: hil.net, hil.vocab, hil.wire, the standard library, any package.

Tests may import too: hil.testing.
"""
