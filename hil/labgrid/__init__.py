"""Benches in labgrid, which reserves them: ``imports: [hil.labgrid]`` in an environment of labgrid's.

``bench_resource.py`` is what an exporter has of a bench, ``bench_driver.py`` gives a test its face. Labgrid's
coordinator knows who has a place; the driver takes the bench's lease, too, where the bench knows its users.

May import: hil.client, hil.vocab, the standard library, attr, labgrid.
"""

from hil.labgrid.bench_driver import HilBenchDriver
from hil.labgrid.bench_resource import HilBench

__all__ = ["HilBench", "HilBenchDriver"]
