"""TMCL, the language of Trinamic's motion modules, on RS485: axes as modules, each a station of a segment.

``frames.py`` are the bytes, ``splitter.py`` and ``framing.py`` what a line and a capture make of them,
``words.py`` how they are printed. ``tmcl_model.py`` and ``tmcl_findings.py`` are the keys of a configuration,
``segment_nodes.py`` puts the modules of ``card`` on a segment; ``drives`` are real ones.
``bus_kind.py`` is what hil asks for.
"""
