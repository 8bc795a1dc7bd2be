"""Listening and asking.

``acceptor.py``, ``visitors.py`` and ``limits.py`` let clients in, and only so many; ``tcp_port.py`` is a
port's listener. ``control_client.py``, ``benches_here.py`` and ``port_client.py`` are the side that asks;
they import little: who asks starts quickly.

May import: hil.host, hil.vocab, the standard library, pydantic.
"""
