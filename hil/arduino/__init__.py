"""Pluggable discovery and monitor: devices of running benches in the Arduino IDE and arduino-cli.

``protocol.py`` has the two dialogues, pure: a line in, messages out. ``discovery.py`` and ``monitor.py`` are
the programs that the IDE starts; ``install.py`` names them to it, in the folders that ``sketchbooks.py``
finds.

Sources: "Pluggable discovery specification", "Pluggable monitor specification" and "Platform specification"
of the arduino-cli documentation, protocol version 1. The IDE 1.8 (from 1.8.9) has an earlier discovery and no
such monitor: PluggableDiscovery, BoardPort and BaseNoGui in the sources of 1.8.13 and 1.8.19.

May import: hil.config, hil.host, hil.net, hil.vocab, the standard library, yaml.

Tests may import too: hil.cli, hil.compose.
"""
