"""Agent in the guest: carries out what comes over the second serial line, one shell command a line.

What it prints goes back as it comes; a line of EOT (4) and the exit status ends it.
"""

import os
import subprocess
import tty

port = os.open("/dev/ttyS1", os.O_RDWR | os.O_NOCTTY)
tty.setraw(port)
os.write(port, b"\x04 0\n")  # ready
with os.fdopen(port, "rb", buffering=0) as lines:
    for line in lines:
        done = subprocess.run(line.decode(), shell=True, stdin=subprocess.DEVNULL, stdout=port, stderr=port)
        os.write(port, f"\n\x04 {done.returncode}\n".encode())
