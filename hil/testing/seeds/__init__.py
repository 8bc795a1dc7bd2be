"""Many seeds of one test: ``pytest --hil-seeds 1000``, in one process, side by side, in shards and on a
farm.

``bench_chance.py`` has the seeds of a bench's faults and axes, all drawn from one; ``late_arrivals.py`` the
bytes that come some time after they were written. ``seed_options.py`` reads what a command line says,
``seed_plugin.py`` has pytest's options. ``seeded_items.py`` runs a test at a seed (``seed_run.py``), and
again with fewer faults where it fails (``smallest_faults.py``). ``seed_recorder.py`` collects the results,
lines of files too (``seed_results.py``), ``seed_merge.py`` joins those of shards, and ``seed_summary.py`` has
the words.

``farm.py`` hands seeds to workers of Dask: ``farm_worker.py`` is what they run, ``farm_process.py`` the
pytest there, ``sent_sources.py`` the tests on their way.

May import: hil.config, hil.sim, hil.vocab, the standard library, _pytest, distributed, pytest.

Tests may import too: device_profiles, hil.compose, hil.testing, hypothesis.
"""
