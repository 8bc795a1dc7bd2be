"""A TCP listener that carries raw bytes, as ``socket://`` of pyserial and ``nc`` speak them.

Imports ``hil.vocab.ports`` and nothing else of the project.
"""
