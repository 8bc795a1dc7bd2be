"""A pseudo-terminal with a stable name, which terminal programs and pyserial open like a serial port.

``pty_port.py`` is the port, ``port.py`` what a configuration needs of it; ``pair.py`` is the pty's two
ends, with ``terminal_settings.py``; ``clients.py`` counts who has it open, told by ``inotify.py``;
``stable_name.py`` is the symlink.

What a pty cannot do, whatever runs behind it: modem lines and break (a client that asks for DTR or RTS
after opening gets ENOTTY), parity and 7 bits (the kernel drops them silently), and an entry in a
tool's list of serial ports (the path has to be typed). It cannot tell which client has stopped the output
(tcflow) either: the stop ends when any of them closes.
"""
