"""What may be asked of a bench, and who answers; health and metrics, which are readings of it.

The control socket's side that answers is here (``control_socket.py``); the side that asks is
``hil.net.control_client``. Imports ``hil.live`` and below.
"""
