"""Listening, admission and limits, and a port's TCP listener; and asking: a control socket, a port, which
benches run here.

The modules that ask import little: who asks starts quickly.

May import: hil.host, hil.vocab, hil.wire, the standard library, pydantic.
"""
