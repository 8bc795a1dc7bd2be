"""The zenoh bridge: axes, segments and ports of a bench under ``hil/<bench>/``.

``keys.py`` is the table of the keys; ``bench_session.py`` has the session, ``command_handler.py`` and
``readings.py`` answer, ``publications.py`` publishes. Permissions: ``users.py`` reads the users' file,
``gate.py`` checks signatures, ``access.py`` is zenoh's own access control; ``site_*.py`` have members by
certificates, with a signed list. ``testing`` has sessions for tests on a bench in memory.

May import: hil.net, hil.testing.doors, hil.vocab, hil.wire, the standard library, any package.

Tests may import too: hil.client, hil.testing.
"""
