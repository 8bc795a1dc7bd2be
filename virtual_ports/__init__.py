"""Where bytes enter: one folder for each kind of port, found by its name when a configuration names it.

Each folder has a ``port.py`` with ``Options`` (a strict pydantic model) and
``make(options, context) -> Port``. A port imports ``hil.vocab``, ``hil.wire`` and its own folder,
nothing else of the project; it knows no device, no simulated time and no other port.
"""
