"""Command ``hil gcode``: a program in G-code over a line, or by runs of a bench.

``gcode_command.py`` has the command, ``gcode_files.py`` reads and plans, ``gcode_line.py`` carries out over a
line, ``gcode_runs.py`` by runs, ``gcode_plot.py`` draws what was followed.

May import: hil.cli.framework, hil.cli.lines, hil.cli.runs, hil.compose, hil.gcode, hil.host, hil.master,
hil.net, hil.telemetry, hil.toolpath, hil.vocab, the standard library, rich, typer.
"""
