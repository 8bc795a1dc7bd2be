"""Commands ``hil capture``, ``hil decode``, ``hil line play``: traffic kept, shown in words, played again.

``capture_commands.py`` has the commands, ``capture_run.py`` runs a capture, ``capture_targets.py`` says where
it goes, ``capture_files.py`` and ``capture_input.py`` write and read files, ``time_order.py`` and
``counted_blocks.py`` order and count what is in them. ``hil.compose.decoding`` puts packets and frames into
words. Frames and logs of a bus are its own, by its ``LogKind``.

May import: hil.cli.framework, hil.compose, hil.discovery, hil.host, hil.net, hil.vocab, hil.wire,
the standard library, typer.
"""
