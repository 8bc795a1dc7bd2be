"""Commands ``hil sketch``: sketches that are built, and boards' processors that run them.

``build_command.py`` builds; ``chip_commands.py`` loads a program and shows what is in the chip,
``time_commands.py`` where its time goes, ``plot_command.py`` what it prints, ``gdb_command.py`` lets GDB in.
``program_files.py`` reads programs.

May import: hil.cli.boards, hil.cli.captures, hil.cli.framework, hil.host, hil.net, hil.sketch, hil.telemetry,
hil.toolchain, hil.vocab, hil.wire, the standard library, typer.
"""
