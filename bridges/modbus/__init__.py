"""Modbus: all that this bus alone has, from bytes on a line to registers of an axis.

``protocol`` are requests and answers as bytes, on TCP and on a serial line; ``registers`` what a device shows
and takes; ``unit_transaction.py`` carries a request to a unit out, for nodes and doors alike. ``door`` has
axes as units of Modbus TCP, with or without TLS, and of serial lines; ``bridge.py`` is the bridge that it is,
``cli.py`` its commands.

May import: hil.net, hil.vocab, hil.wire, the standard library, any package.
"""
