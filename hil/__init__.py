"""A bench of virtual boards. Each room's docstring says what is in it and what it may import.

No room knows a board, a port or a bridge by name: those live in the sibling packages ``device_profiles``,
``virtual_ports`` and ``bridges``, and are found by their folder's name when a configuration names them. What
a room's tests import from above it, its docstring names.
"""

__version__ = "0.2.0"
