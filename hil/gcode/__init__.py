"""G-code (RS-274/NGC): text of a program to canonical motions, and every problem with its place.

``reader.py`` reads a program, most lines at once. ``canonical.py`` has what comes out: motions in millimetres
and degrees, in machine coordinates, with offsets, units and modes applied. A plan of boards needs no other
word of the language.

Inside, along the data: ``program_text.py`` makes lines of bytes, ``block.py`` sorts the words of a line, with
``expressions.py`` for their values, ``interpreter.py`` carries them out on a ``state.py``; ``conflicts.py``
says which words do not go together, ``arcs.py`` where an arc's centre is. ``words.py`` is the table of
all words.

Pure: a text and the state of a machine come in, a program goes out.

Source: T. Kramer, F. Proctor, E. Messina, The NIST RS274/NGC Interpreter, version 3, NISTIR 6556, 2000.

May import: hil.vocab, the pure standard library.
"""
