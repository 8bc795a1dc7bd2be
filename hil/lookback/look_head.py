"""Form of what the process that looks at a recording answers: ``HEAD`` and so many bytes."""

from struct import Struct

HEAD = Struct("<IBI")
"""Number of the request, how it ended, and the length of the text that follows."""
GIVEN, REFUSED, DROPPED = 0, 1, 2
"""Ends of a request: JSON follows; why there is no answer; a newer one took its place."""
WORKER = "hil.lookback.look_process"
