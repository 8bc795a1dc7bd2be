"""Boards by a table: what an instrument understands, what it answers, what its values do meanwhile.

``instrument_table.py`` is the table, which ``hil.config`` makes of ``dialogue`` in a ``profile.yaml``;
``instrument.py`` is the board's program that goes by it. ``command_cuts.py`` cuts what comes into commands,
``patterns.py`` and ``scpi.py`` read them, ``matching.py`` finds the row that one is, ``templates.py`` writes
answers, ``table_expressions.py`` computes, ``slow_values.py`` has the values, ``check_sums.py`` has what
stands at the ends of commands.

Pure: bytes and simulated time come in, bytes go out. A command is read in time in proportion to its length.

May import: hil.vocab, the pure standard library, ast.
"""
