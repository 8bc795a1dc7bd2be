"""Parts that all commands share, and the command line that is made of one table.

``command_table.py`` says which commands and groups there are and where each is, and which names their values
take. ``command_group.py`` makes the command line of it, with the classes of ``command_classes.py``;
``usage_errors.py`` says what is wrong with a line, in the words of ``usage_words.py``;
``board_commands.py`` adds the commands of boards and bridges. ``ask.py`` has the options that say which bench
is meant, and ``fail``, which tells errors; ``command_answers.py`` tells answers, in JSON too, and
``exit_codes.py`` has their codes.
``problem_lines.py``, ``shown_words.py``, ``consoles.py`` and ``progress_bars.py`` show things to people,
``interrupts.py`` ends commands early, ``installed_files.py`` finds what comes with hil beside its modules.
No command stands here.

May import: hil.discovery, hil.host, hil.net, hil.vocab, the standard library, rich, serial, typer.
"""
