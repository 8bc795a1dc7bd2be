"""Bridges, doors of a bench for other protocols: one folder for each, found by its name when a configuration
names it.

Each folder has a ``bridge.py`` with ``Options`` (a strict pydantic model), ``reference()`` (its part of the
reference) and ``make(options, desk) -> Bridge``. The desk (``hil.vocab.bridges.Desk``) is all that a bridge
has of a bench: through it a bridge asks for operations of the table, watches, and describes the bench. A
bridge knows no board by name.

Each may import: hil.net, hil.vocab, hil.wire, the standard library, any package.
"""
