"""The core: devices' time, firmware runtime, sessions, configuration, daemon and test kit.

It knows no device, port or bridge by name: those live in the sibling packages
``device_profiles`` and ``virtual_ports`` and are found by their folder's name when a
configuration names them.
"""

__version__ = "0.1.0"
