"""Faces of a CAN bus for the test kit.

``can_faces.py`` are a bus with a node of the test's, an adapter's serial line and a CANopen drive, which it
asks by SDO; ``served_can.py`` is the bus of a bench that is served; ``python_can_bus.py`` is the bus for code
with python-can. ``fixtures.py`` are fixtures of pytest.

May import: bridges.can, hil.config, hil.sim, hil.testing, hil.vocab, the standard library, any package.

Tests may import too: hil.wire.
"""
