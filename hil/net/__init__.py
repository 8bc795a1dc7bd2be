"""Listening, admission and limits; and asking: a control socket, a port, which benches run here.

Imports ``hil.host`` and ``hil.vocab``. The modules that ask import little: who asks starts quickly.
"""
