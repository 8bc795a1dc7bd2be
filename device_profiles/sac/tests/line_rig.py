"""SACs on a segment, and a master that sends them the commands of a plan in simulated time."""

from device_profiles.sac.packet import encode
from device_profiles.sac.path_planner import PATHS
from hil.testing import Bench
from hil.vocab.path_planning import StepperAxis

FIRST_NODE = 4
CHARACTER_MS = 10 / 38.4
ROOM = PATHS.queue_length - 1


class LineRig:
    """SACs ``s0``, ``s1``..., one for each microstep exponent, at the nodes from 4 on."""

    def __init__(self, exponents, slow_rpm=10):
        self.axes = {f"s{i}": StepperAxis(200, j, slow_rpm) for i, j in enumerate(exponents)}
        names = list(self.axes)
        segment = {"stations": names, "taps": {"master": {}}}
        devices = {name: {"profile": "sac"} for name in names}
        self.bench = Bench({"bench": "line", "devices": devices, "segments": {"bus0": segment}})
        self.bench.run(ms=1100)
        for i, name in enumerate(names):
            port = self.bench.port(name)
            for line in (f"$CM{FIRST_NODE + i}", f"$CJ{exponents[i]}", f"$CL{slow_rpm}", "$R"):
                port.write(line.encode() + b"\r")
                self.bench.run(ms=60)
        self.tap = self.bench.tap("bus0.master")
        self.late = 0
        """Number of commands that came after they were needed."""
        self._windows = []

    def send(self, node, data):
        """Send a command, and wait for its acknowledgement."""
        self.tap.write(encode(node, 1, data))
        self.bench.run(ms=PATHS.line_characters(len(data)) * CHARACTER_MS + 0.1)
        assert encode(1, node, b"\6") in self.tap.read()

    def perform(self, phrase, ahead=ROOM, at_us=lambda at_us: None):
        """Carry out a phrase, each command as early as its board has room. ``at_us`` is called with the time
        since the release before each command. Answers the commands."""
        commands = iter(phrase.commands)
        sent = {name: [] for name in self.axes}
        done = []

        def has_room(command, now_us):
            return sum(start_us > now_us for start_us in sent[command.axis]) < ROOM

        def send(command):
            sent[command.axis].append(command.start_us)
            self.send(FIRST_NODE + list(self.axes).index(command.axis), command.data)
            done.append(command)

        todo = next(commands, None)
        while todo and len(sent[todo.axis]) < ahead:
            send(todo)
            todo = next(commands, None)
        begin_ns = self.bench.now_ns
        self.tap.write(encode(0, 1, PATHS.release))
        self.bench.run(ms=len(encode(0, 1, PATHS.release)) * CHARACTER_MS)
        release_ns = self.bench.now_ns
        while todo:
            now_us = (self.bench.now_ns - release_ns) / 1000
            at_us(now_us)
            if has_room(todo, now_us):
                send(todo)
                self.late += (self.bench.now_ns - release_ns) / 1000 > todo.needed_us
                todo = next(commands, None)
            else:
                self.bench.run(ms=1)
        end_us = max(command.end_us for command in done)
        self.bench.run(ms=max(end_us - (self.bench.now_ns - release_ns) / 1000, 0) / 1000 + 5)
        self._windows.append((begin_ns, self.bench.now_ns))
        return done

    def pulses(self):
        """Times of the pulses of each axis, for each phrase, in nanoseconds."""
        edges = {name: self.bench.device(name).pin("clk").edges() for name in self.axes}
        return [
            {name: [at for at, level in each if level and begin <= at < end] for name, each in edges.items()}
            for begin, end in self._windows
        ]
