"""Modbus RTU on a line: frames told apart by silence. Codec and framing; no functions of the protocol.

``frame.py`` has frames, their CRC and the silences, ``splitter.py`` a listener to the line, ``exchange.py``
tells questions from answers, which ``frame_words.py`` says in words; ``rtu_framing.py`` is what a segment
asks. Many kinds of boards may speak it, so it is here and in no board's folder.

Source: MODBUS over Serial Line, Specification and Implementation Guide V1.02, 2.5.1 (RTU transmission mode).

May import: hil.vocab, hil.wire, the pure standard library.
"""
