"""How the bench is, as long as it runs: for ``hil status``, bridges and metrics.

``vitals.py`` and ``process.py`` observe, ``health.py`` judges, ``metrics.py`` is the table of what is
counted. Whether the system is fit for a bench is the question of ``hil.daemon.linux``. Imports no other room
of the daemon.
"""
