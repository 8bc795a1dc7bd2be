"""A real serial port, of this computer or another: a device node, ``socket://`` or ``rfc2217://``."""
