"""What may be asked of a bench, and who answers.

``table.py`` is the one table of operations, ``desk.py`` checks what is asked against it,
``board_operations.py`` and its sisters answer. The control socket is the door that is always open
(``control_socket.py``; the side that asks is ``hil.net.control_client``); other doors are bridges. Health,
metrics and reports are readings.

May import: hil.compose, hil.config, hil.core, hil.firmware, hil.host, hil.live, hil.net, hil.runs, hil.sim,
hil.telemetry, hil.vocab, hil.wire, the standard library.
"""
