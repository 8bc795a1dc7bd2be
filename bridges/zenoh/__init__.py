"""The zenoh bridge: axes, segments and ports of a bench under ``hil/<bench>/``.

``keys.py`` is the table of the keys; ``bridge.py`` answers, ``publications.py`` tells, ``security.py`` says
who may.
"""
