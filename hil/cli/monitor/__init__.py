"""Command ``hil monitor``: a serial monitor in the terminal, at a port of a running bench.

``monitor_command.py`` reads the options, ``monitor_session.py`` carries bytes both ways, also to a bench that
comes again. ``typed_keys.py`` says what keys send, ``shown_bytes.py`` how what came is shown; both are pure.
``port_look.py`` looks where the port is and who has it, ``timed_bytes.py`` hears at which times bytes come.

May import: hil.cli.boards, hil.cli.captures, hil.cli.framework, hil.host, hil.net, hil.vocab, hil.wire,
the standard library, typer.
"""
