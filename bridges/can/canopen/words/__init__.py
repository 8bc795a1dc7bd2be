"""CANopen in words: what each frame on the wire says, for people.

``canopen_words.py`` describes frames, ``sdo_words.py`` those of a dialogue, ``pdo_words.py`` values of
process data once their mapping is known; ``canopen_fields.py`` has the fields of each; ``object_words.py``
has names and types of objects, of which ``eds_names.py`` reads more. Nothing here is a node, or decides what
one answers: a frame that is wrong is described as well as it can be.

Sources: CiA 301 (application layer), CiA 305 (LSS), CiA 402 (drives).

May import: bridges.can.canopen, bridges.can.frames, hil.vocab, hil.wire.outside_text, hil.wire.packet_fields,
the pure standard library.
"""
