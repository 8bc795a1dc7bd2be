"""CANopen as it stands on the wire: its frames as bytes, and what each says in words, for people.

``sdo_frames.py`` builds SDO frames and takes them apart, ``cia402_words.py`` has the states, words and modes
of drives: for the node, the master and the words alike.

``canopen_words.py`` says frames, ``sdo_words.py`` those of a dialogue, ``pdo_words.py`` values of process
data once their mapping is known; ``object_words.py`` has names and types of objects, of which
``eds_names.py`` reads more; ``can_ids.py``, ``canopen_codes.py`` and ``abort_codes.py`` have identifiers and
codes. Nothing here is a node, or decides what one answers: a frame that is wrong is said as well as it can
be.

Sources: CiA 301 (application layer), CiA 305 (LSS), CiA 402 (drives).

May import: hil.vocab, hil.wire.can, hil.wire.left_out, hil.wire.outside_text, the pure standard library.
"""
