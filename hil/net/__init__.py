"""Listening for clients, and asking as one.

``acceptor.py`` and ``visitors.py`` let clients in, and only so many; ``fair_share.py`` gives them their
shares of the loop; ``tcp_port.py`` is a port's listener; ``listeners.py`` opens those of ports
and bridges, at an address that ``endpoint.py`` reads for their ``listen_option.py``, and says why one cannot
be had, with ``address_holder.py``. ``control_client.py`` and ``port_client.py`` ask, ``benches_here.py``
finds whom: these import little, so that a command starts quickly. ``answers.py`` checks answers,
``axis_states.py`` has words for states of axes in them, ``condition.py`` reads conditions on states,
``signature.py`` signs commands. ``silence_timer.py`` times silences of lines. ``site_stop.py`` stops all
benches behind a session of zenoh. ``door_check.py`` finds out why a door lets nobody in.

May import: hil.host, hil.vocab, hil.wire, the standard library, cryptography, pydantic,
pydantic_core, zenoh.
"""
