"""Runs of a bench in real time: those that wait, those that move, and how they ended.

``queue.py`` has them all, ``planning.py`` plans them, ``carry_out.py`` moves the axes. ``lead.py`` leads a
run that spans benches, ``part.py`` is this bench's part of one that another leads, ``other_benches.py``
reaches the others, ``asked_again.py`` asks again what was lost, ``axis_names.py`` tells axes of several
benches apart. ``hil.live.devices`` finds the
axes of a bench. ``hil.runs`` says what a run is and plans it.

May import: hil.config, hil.live.bridges, hil.live.core_thread, hil.live.configured, hil.live.reservations,
hil.live.off_loop, hil.runs, hil.sim, hil.vocab, hil.wire, the standard library.
"""
