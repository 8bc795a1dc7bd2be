"""Modbus as it stands on the wire: requests and answers, TCP's header before them, and frames of a line.

``pdu.py`` parses requests and makes answers, ``identification.py`` says what a device is (function 43/14),
``diagnostics.py`` what a node of a serial line says of it (functions 8 and 17). ``client_side.py`` makes
requests and parses answers. ``mbap.py`` splits a TCP stream. Of Modbus RTU ``frame.py`` has frames and their
CRC, ``splitter.py`` a listener to the line, ``exchange.py`` tells questions from answers, which
``frame_words.py`` says in words; ``poll_cycle.py`` says how long a master's cycle takes, ``rtu_framing.py``
is what a segment asks. Nothing here knows what a register means.

Sources: MODBUS Application Protocol Specification V1.1b3; MODBUS over Serial Line, Specification and
Implementation Guide V1.02, 2.5.1 (RTU transmission mode). Their sections stand in parentheses.

May import: hil.vocab, hil.wire, the pure standard library.
"""
