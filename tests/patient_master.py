"""Runs a program that uses the ``canopen`` library with ten times the library's patience.

Its time-outs of 0.2 to 0.8 s are for drives on a desk, not for a computer that runs all tests at once.
Arguments: the program, and its own.
"""

import runpy
import sys

from canopen.profiles.p402 import BaseNode402
from canopen.sdo.client import SdoClient

for owner in (SdoClient, BaseNode402):
    for name in dir(owner):
        if "TIMEOUT" in name:
            setattr(owner, name, 10 * getattr(owner, name))
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
