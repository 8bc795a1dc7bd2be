"""Pluggable discovery and monitor: devices of running benches in the Arduino IDE 2 and arduino-cli.

``protocol.py`` has the two dialogues, pure: a line in, messages out. ``discovery.py`` and ``monitor.py`` are
the programs that the IDE starts; ``install.py`` tells it of them.

Sources: "Pluggable discovery specification", "Pluggable monitor specification" and "Platform specification"
of the arduino-cli documentation, protocol version 1.

May import: hil.config, hil.host, hil.net, hil.vocab, the standard library, yaml.
"""
