"""Joins ports to devices: the path of a byte, the groups' advance, inputs and their log.

``session.py`` is the place where the layers meet. Imports ``hil.vocab``, ``hil.wire``,
``hil.firmware`` and ``hil.core``; never a profile or a port by name, nor configuration or daemon.
"""
