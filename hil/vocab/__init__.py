"""The words every other room is written in: NewTypes, frozen dataclasses, Protocols, and tables of them.

Behaviour stands elsewhere.

May import: the pure standard library, difflib, pathlib.
"""
