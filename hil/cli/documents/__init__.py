"""Texts that are written from the command line and the tables in the code: completion, man page, reference.

``command_tree.py`` reads the command line as data. ``completion.py`` writes the scripts of shells,
``completion_names.py`` the names that they ask for, ``man.py`` the man page, ``reference.py`` the reference,
with the tables of ``surroundings.py``. ``help_commands.py`` has the commands that print them.
``docs_command.py`` shows pages: ``page_text.py`` finds their headings, ``shown_page.py`` lays them out.
``command_page.py`` writes the page of commands, which begins with those of ``tasks.py``; ``shown_help.py`` is
`hil help`.

May import: hil.cli.bench, hil.cli.captures, hil.cli.framework, hil.compose, hil.config, hil.core,
hil.discovery, hil.gcode, hil.host, hil.net, hil.operations, hil.recorded, hil.runs, hil.sim, hil.toolpath,
hil.vocab, the standard library, rich, typer.
"""
