"""Modbus: all that this bus alone has, from bytes on a line to registers of an axis.

``protocol`` are requests and answers as bytes, on TCP and on a serial line; ``registers`` what a device shows
and takes; ``unit_transaction.py`` carries a request to a unit out, for cards and doors alike. ``card`` is
the interface card of a twin, a node of a line. ``door`` has axes as units of Modbus TCP, with or without TLS,
and of serial lines; ``bridge.py`` is the bridge that it is, ``cli.py`` its commands.

May import: hil.core, hil.net, hil.sim, hil.vocab, hil.wire, the standard library, any package.
"""
