"""Start and reload, which make the bench what the configuration says: a start is a reload from a bench
without devices.

Steps that can fail come first, in this order; when one fails, nothing has changed. ``bench_plan.py`` reads
configuration, memories and tables. ``reload.py`` checks that the running bench can be changed so (at a start
there is nothing to check). ``staging.py`` makes new devices and opens new ports beside what runs.
``fail_first.py`` calls these in this order, waits for memories that are being written, and puts away files of
other boards. Then ``swap.py`` puts the new in the old's place. That cannot fail any more, except a fault of
the configuration that a start refuses; errors of old ports that are closed finally are only logged.
``docs/follow-a-reload.md`` walks these files.
"""
