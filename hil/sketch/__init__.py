"""Compiled sketches for a processor of a bench: files of programs, read and written as data.

``chip_program.py`` makes a program of a file, and packs it for a board's memory; ``intel_hex.py`` and
``elf_file.py`` read the files, ``chip.py`` has what the ATmega328P has room for. ``register_names.py`` and
``function_names.py`` have names for what is in the chip, ``program_notes.py`` words for what goes wrong.
``printed_numbers.py`` reads what a sketch prints for a plotter.

Pure: bytes come in, a program or an error with its place comes out.

May import: hil.vocab, the pure standard library.
"""
