"""Modbus beside its framing: what a request asks, what its answer is, and TCP's header before both.

``pdu.py`` parses requests and makes answers, ``identification.py`` says what a device is (function 43/14),
``diagnostics.py`` what a node of a serial line says of it (functions 8 and 17). ``client_side.py`` makes
requests and parses answers. ``mbap.py`` splits a TCP stream; a serial line's frames are told apart by
``hil.wire.modbus_rtu``. Nothing here knows what a register means.

Source: MODBUS Application Protocol Specification V1.1b3, whose sections stand in parentheses.

May import: hil.vocab, the pure standard library.

Tests may import too: hil.wire.
"""
