"""The command ``hil``: each command, what it draws, its completion, its man page and the reference.

Belongs here: what a user types and reads. ``entry.py`` is where the program begins, ``cli.py`` has the
commands or says where they are, ``ask.py`` what those share that ask a running bench. May import every other
room, but does so when a command runs: each starts quickly. No other room imports it.
"""
