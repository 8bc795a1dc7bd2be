"""How the bench becomes what the configuration says: a start is a reload from a bench without devices.

What can fail comes first, and in this order; where it fails, nothing has changed. ``bench_plan.py`` reads
configuration, memories and tables. ``reload.py`` looks whether the running bench can be changed so (at a
start there is nothing to look at). ``staging.py`` makes new devices and opens new ports beside what runs.
``fail_first.py`` has it all done in this order, waits for memories that are being written, and puts away
files of other boards. Then ``swap.py`` puts the new in the old's place. That cannot fail any more; what goes
wrong while old ports are closed at last is only logged. ``docs/follow-a-reload.md`` walks
these files.
"""
