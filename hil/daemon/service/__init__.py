"""The daemon as a service: what systemd is told and when, and a log that its journal understands.

``notify.py`` and ``journal.py`` are systemd's two protocols, ``service.py`` says when there is something to
tell; ``log_writer.py`` is the thread that writes the log. Imports no other room of the daemon.
"""
