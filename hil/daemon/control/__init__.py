"""The control socket: what ``hil``'s commands talk to, on both sides.

``server.py`` takes requests, from whom ``door.py`` lets in; ``requests.py`` reads them. ``verbs.py`` answers
them, ``run_verbs.py`` those about runs; ``watches.py`` has the samples that clients wait for. They may import
the rooms ``health``, ``reload`` and ``runs``.
``client.py`` asks; it imports nothing of the project, so that who asks starts quickly.
"""
