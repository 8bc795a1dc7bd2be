"""The words every other room is written in: NewTypes, frozen dataclasses, Protocols, and tables of them.

What does something with them stands elsewhere.

May import: the pure standard library, pathlib.
"""
