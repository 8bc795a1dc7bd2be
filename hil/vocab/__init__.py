"""The words every other room is written in: NewTypes, frozen dataclasses and Protocols.

May import: the pure standard library, pathlib.
"""
