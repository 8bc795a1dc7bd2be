"""RS485 segments: a wire that stations share. ``segment.py`` is pure: simulated time is an argument."""
