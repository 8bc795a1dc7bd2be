"""Doors for other protocols: one folder for each, found by its name when a configuration names it.

Each folder has a ``bridge.py`` with ``Options`` (a strict pydantic model) and
``make(options, host) -> Bridge``. A bridge imports ``hil.vocab`` and its own folder, nothing else of the
project; it knows no board by name.
"""
