"""A pseudo-terminal with a stable name, which terminal programs and pyserial open like a serial port.

``pty_port.py`` is the port, ``port.py`` what a configuration needs of it; ``pair.py`` is the pty's two
ends, with ``terminal_settings.py``; ``clients.py`` counts who has it open, told by ``inotify.py``;
``hil/net/stable_name.py`` is the symlink.

A pty has no modem lines and no break: a client that asks for DTR or RTS after opening gets ENOTTY. It has no
parity and no 7 bits: the kernel drops them silently. Few tools list it (``hil.vocab.port_programs``). It
cannot tell which client has stopped the output (tcflow): the stop ends when any of them closes.
"""
