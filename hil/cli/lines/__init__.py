"""Commands ``hil line``: the master of a line, its nodes, their queues.

``named_lines.py`` finds lines and says what became of packets; the other modules have the commands. Programs
in G-code are in ``hil/cli/gcode``.

May import: hil.cli.framework, hil.master, hil.net, hil.vocab, the standard library, rich, typer.
"""
