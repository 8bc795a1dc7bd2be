"""Modbus: all that this bus alone has, from bytes on a line to registers of an axis.

``protocol`` are requests and answers as bytes, on TCP and on a serial line; ``registers`` what a device shows
and takes; ``unit_transaction.py`` carries a request to a unit out, for cards and doors alike. ``card`` is the
interface card of a twin, a node of a line. ``door`` has axes as units of Modbus TCP, with or without TLS, and
of serial lines; ``bridge.py`` is the bridge that it is, ``cli.py`` its commands. ``master`` polls units on a
line. ``bus_kind.py`` is what hil asks this folder for; ``modbus_model.py`` and ``modbus_findings.py`` are the
keys of nodes in a configuration, ``segment_nodes.py`` puts them on a segment. ``testing`` has clients for
tests on a bench in memory.

May import: hil.config, hil.core, hil.drives, hil.firmware, hil.master, hil.net, hil.sim,
hil.testing.doors, hil.testing.given, hil.vocab, hil.wire, the standard library, any package.

Tests may import too: hil.compose, hil.live.log_file, hil.memory_desk, hil.testing.
"""
