"""Operations of a bench: the table of all (``table.py``), and the desk that checks permissions and carries
them out (``desk.py``).

Each operation is carried out by one of the ``*_operations`` or by ``reports``, which name the
parts that they need; health and metrics are readings of such parts. The control socket is a door as bridges
are: it has the desk and nothing else. The side that asks there is ``hil.net.control_client``.

No operation knows what kind of device it has: it calls ``hil.vocab.device.Device``, and the sign below leaves
the kinds out.

May import: hil.config, hil.core, hil.host, hil.live.apply, hil.live.captures, hil.live.core_thread,
hil.live.configured, hil.live.devices.bench_devices, hil.live.fault_registry, hil.live.held_time,
hil.live.live_bench, hil.live.memory_commits, hil.live.off_loop, hil.live.places, hil.live.refusals,
hil.live.run_recording, hil.live.runs, hil.live.standing_time, hil.live.vitals, hil.live.watches,
hil.lookback.look_head, hil.net, hil.runs, hil.sim.bench, hil.sim.card, hil.sim.client_tap,
hil.sim.input_check, hil.sim.input_reading, hil.sim.inputs, hil.sim.noted_events, hil.sim.segment_tap,
hil.sketch, hil.toolpath, hil.vocab, hil.wire, the standard library.

Tests may import too: hil.client, hil.compose, hil.daemon, hil.discovery.named_kinds, hil.live.port_link,
hil.testing.
"""
