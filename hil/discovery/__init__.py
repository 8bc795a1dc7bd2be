"""Finds boards, kinds of ports and bridges, and buses: those with hil, in folders that a user names, and in
packages installed beside hil; and loads what they say of themselves.

Belongs here: where each is, the import of its one name, and what can be wrong with it, each with its place.
Light, because each start of a command waits for it. They are somebody else's code: whatever it raises is a
problem of that board or kind.

May import: hil.vocab, the standard library.

Tests may import too: hil.compose.
"""
