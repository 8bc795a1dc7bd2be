"""Modbus nodes: interface cards of axes, stations of their own on a segment, in simulated time.

``rtu_receiver.py`` makes frames of what a station hears, ``modbus_node.py`` is the station, which spoils
answers where a fault says so, ``register_server.py`` carries out its requests at one moment,
``verb_ends.py`` says when a motion that one began has ended. A node is an input of nothing: its inputs are
the bytes on the wire.

May import: bridges.modbus.protocol, bridges.modbus.registers, bridges.modbus.unit_transaction, hil.core,
hil.sim, hil.vocab, hil.wire, the pure standard library.
"""
