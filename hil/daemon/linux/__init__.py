"""What Linux gives the daemon, what it refuses and why, and the line that mends it.

``system.py`` reads and ``probes.py`` tries; ``real_time.py`` and ``open_files.py`` take what there is;
``doctor.py`` and ``doctor_benches.py`` judge, for ``hil doctor``. The only other room of the daemon that may
be imported is ``control``, for its client: benches are asked how they are.
"""
