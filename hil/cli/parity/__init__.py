"""Command ``hil parity``: a real board beside its twin.

``session_choice.py`` finds the sessions that are meant, ``board_port.py`` the port, ``parity_command.py``
types them at both, ``parity_views.py`` shows the scores.

May import: hil.cli.boards, hil.cli.framework, hil.compose, hil.config, hil.discovery, hil.host, hil.testing,
hil.vocab, the standard library, serial, typer.

Tests may import too: hil.cli, hil.net.
"""
