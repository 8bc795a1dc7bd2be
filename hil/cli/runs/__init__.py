"""Commands of multi-axis runs: ``hil run`` and ``hil runs``; and ``hil halt``.

``run_command.py`` submits a run and follows it, ``runs_commands.py`` asks for those there are,
``halt_command.py`` ends them all, and stops what moves;
``run_reports.py`` has the words for how they do.

May import: hil.cli.framework, hil.runs, hil.vocab, the standard library, rich, typer.
"""
