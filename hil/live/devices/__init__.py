"""Devices of a bench at run time: ``twin_device.py``, ``board_device.py`` and ``drive_device.py`` have one
face, ``hil.vocab.device.Device``, and ``bench_devices.py`` has all by their names. Only ``hil.live.apply``
makes them, and knows which is which.

May import: hil.core, hil.drives, hil.live.board_backend, hil.live.chip_debugging, hil.live.memory_commits,
hil.live.motion_wait, hil.live.places, hil.live.port_link, hil.live.program_watch, hil.live.sim_backends,
hil.runs, hil.sim, hil.sketch, hil.telemetry, hil.vocab, hil.wire, the standard library.
"""
