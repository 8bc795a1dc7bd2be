"""What may be asked of a bench, and who answers; health and metrics, which are readings of it.

The control socket's side that answers is here (``control_socket.py``); the side that asks is
``hil.net.control_client``.

May import: hil.compose, hil.config, hil.core, hil.firmware, hil.host, hil.live, hil.net, hil.runs, hil.sim,
hil.telemetry, hil.vocab, hil.wire, the standard library.
"""
