"""The control socket: what ``hil``'s commands talk to, on both sides.

``server.py`` answers, ``run_verbs.py`` has its verbs about runs, ``watches.py`` its clients' samples;
``door.py`` says who may come in. Of the other rooms they may import ``health``, ``reload`` and ``runs``.
``client.py`` asks; it imports nothing of the project, so that who asks starts quickly.
"""
