"""Commands of multi-axis runs: ``hil run FILE``, and ``hil run list`` and the like.

``run_command.py`` submits a run and follows it, ``runs_commands.py`` asks for those there are;
``run_reports.py`` has the words for how they do.

May import: hil.cli.framework, hil.runs, hil.vocab, the standard library, rich, typer.
"""
