"""Commands of a bench as a whole: its configuration, its boards' kinds, its start, what it has, its doctors.

``config_commands.py`` and ``profile_commands.py`` (with the new board of ``new_board.py``) are before the
start, ``serve_command.py`` is the start, ``ready.py`` and ``started.py`` say that the boards answer.
``seeds_command.py`` joins the results of tests.
``stop_command.py`` stops what moves, ``shutdown_command.py`` ends a bench, ``lease_commands.py`` reserves
one.
``bench_commands.py`` asks a bench that runs; ``views.py`` and ``port_views.py`` show it. ``top_command.py``
shows it as it goes on, by ``top_view.py`` with the plots of ``braille_plot.py``.
``log_commands.py`` reads who commanded what.
``doctor_benches.py`` and ``doctor_usb.py`` look at what is left, and at USB. ``arduino_commands.py`` shows
the boards to an IDE.

May import: hil.arduino, hil.cli.framework, hil.cli.lab, hil.cli.runs, hil.compose, hil.config, hil.core,
hil.daemon, hil.discovery, hil.firmware, hil.host, hil.live, hil.net, hil.runs, hil.sim, hil.testing,
hil.toolpath, hil.vocab, hil.wire, the standard library, cryptography, rich, typer.
"""
