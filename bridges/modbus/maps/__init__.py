"""Maps of Modbus drives as they are written: their model, their checks, and what is read of them.

``drive_map_model.py`` has the keys, ``drive_map_overlaps.py`` finds entries that share a register,
``drive_map_text.py`` reads a whole map. What a map says is in ``bridges.modbus.registers.drive_map``.

May import: bridges.modbus.protocol, bridges.modbus.registers, hil.config, hil.vocab,
the pure standard library, pydantic, pydantic_core.

Tests may import too: hil.compose.
"""
