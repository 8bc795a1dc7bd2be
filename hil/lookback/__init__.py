"""Process that shows any time of a recorded run, at low priority: ``python -m hil.lookback.look_process``.

``growing_log.py`` reads a recording as far as it is there. ``seen_run.py`` is its run on the virtual clock,
which keeps the last that passed at ports and on wires. ``check_points.py`` has copies of the process that
stand still at times of the run, each ready to go on from there (``standing.py``). ``look_answers.py`` answers
for one time or window; ``run_marks.py`` finds what a time line shows. ``look_process.py`` takes requests and
hands them out.

May import: hil.compose, hil.config, hil.core, hil.host, hil.net, hil.recorded, hil.sim, hil.telemetry,
hil.vocab, hil.wire, the standard library.

Tests may import too: hil.testing.
"""
