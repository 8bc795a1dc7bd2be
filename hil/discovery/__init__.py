"""Finds boards: those with hil, in folders that a user names, and in packages installed beside hil; and loads
what they say of themselves.

Belongs here: where boards are, the import of ``PROFILE``, and what can be wrong with it, each with its place.
Light, because each start of a board's own command waits for it. A board is somebody else's code: whatever it
raises is a problem of that board.

May import: hil.vocab, the standard library.

Tests may import too: hil.compose.
"""
