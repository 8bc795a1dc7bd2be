"""Kinds of boards, one folder each: its description (``profile.yaml``), firmware and transcripts.

A profile is found by its folder's name when a configuration names it; there is no list to enter it
in. Profiles may import ``hil.vocab``, ``hil.wire`` and ``hil.firmware``, never each other, a port, the
core or a clock: simulated time is an argument.
"""
