"""The words every other room is written in: NewTypes, frozen dataclasses and Protocols.

Imports nothing of the project and no I/O, clock or randomness of the standard library.
"""
