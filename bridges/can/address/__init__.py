"""Addresses of real drives on CAN.

May import: bridges.can.frames, hil.wire.address_keys, the pure standard library.
"""
