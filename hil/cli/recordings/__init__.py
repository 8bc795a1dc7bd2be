"""Commands about runs that were recorded, one file each: ``replay_command.py`` runs one again,
``find_command.py`` searches one, ``export_command.py`` writes one for other programs, ``said_log.py`` shows
what was said in one.

May import: hil.cli.bench, hil.cli.framework, hil.compose, hil.config, hil.daemon, hil.host, hil.live,
hil.net, hil.recorded, hil.sim, hil.telemetry, hil.vocab, the standard library, typer.

Tests may import too: hil.cli, hil.testing.
"""
