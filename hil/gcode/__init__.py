"""G-code (RS-274/NGC): text of a program to canonical motions, and every problem with its place.

``canonical.py`` has what a reader hands on: motions in millimetres and degrees, in machine coordinates, with
offsets, units and modes applied. A plan of boards needs no other word of the language.

Pure: a text and the state of a machine come in, a program goes out.

Source: T. Kramer, F. Proctor, E. Messina, The NIST RS274/NGC Interpreter, version 3, NISTIR 6556, 2000.

May import: hil.vocab, the pure standard library.
"""
