"""The daemon: command line, control socket, health, and the thread that stores boards' memories.

It is the only reader of the environment and of the wall clock; every other room is told. May import every
other room of hil; none of them imports it. Profiles and ports are found by the names in the configuration,
never imported by name.

In this folder itself are the daemon (``daemon.py``), what bridges see of it (``bridge_host.py``), the boards'
store and all that several of the rooms need. Each room says what belongs in it and what it may import.
"""
