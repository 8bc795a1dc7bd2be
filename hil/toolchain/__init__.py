"""Builder of Arduino sketches, and of plain programs for the same chip, with the compiler that is installed.

``ino_source.py`` makes C++ of a sketch's text; ``sketch_sources.py`` finds the files of a sketch and of its
libraries; ``avr_tools.py`` finds the compiler and the Arduino core, and says which package has them.
``sketch_build.py`` runs the compiler, and ``kept_objects.py`` keeps what it made of the core and of
libraries. ``arduino_cli.py`` has arduino-cli build instead, where that is what is installed.

May import: the standard library.

Tests may import too: hil.testing.
"""
