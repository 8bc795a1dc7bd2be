"""The clients of the mixed soak: each a thread that does at random moments what chance of its own says."""

import json
import os
import socket
import subprocess
import threading
import traceback
import urllib.request
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import soak_inputs as inputs
from e2e_support import HIL, TERMINAL, Client
from soak_benches import LINE, Config, axes, changed, targets

from hil.client import ClientError, connect_sync
from hil.net.control_client import BenchSilent, ControlError, ask
from hil.vocab.faults import FAULT_KINDS

ASK_S = 30.0
"""Maximum wait for an answer: a daemon that takes longer does not work."""


class Scene:
    """State that the clients of one daemon share. ``troubles``: what must not have happened."""

    def __init__(
        self, seed: int, config: Config, file: Path, control: Path, zenoh: str, metrics: str
    ) -> None:
        self.seed, self.config, self.file, self.control = seed, config, file, control
        self.zenoh, self.metrics = zenoh, metrics
        self.profiles = {name: str(each["profile"]) for name, each in config["devices"].items()}
        self.over = threading.Event()
        self.counts: Counter[str] = Counter()
        self.troubles: list[str] = []

    def random(self, who: str) -> Random:
        """Random numbers of a client's own."""
        return Random(f"{self.seed} {who}")

    def ask(self, verb: str, patience_s: float = ASK_S, **arguments: Any) -> Any:
        """Ask the daemon; None if the request was refused."""
        self.counts["asked"] += 1
        try:
            return ask(self.control, verb, timeout_s=patience_s, **arguments)
        except ControlError as error:
            self.counts["refused"] += 1
            if isinstance(error, BenchSilent) and not self.over.is_set():
                self.troubles.append(f"{verb} {str(arguments)[:200]}: {error}")
            return None


class Actor(threading.Thread):
    """Calls ``act`` after pauses of ``pause_s`` on average, until the scene is over."""

    pause_s = 0.1

    def __init__(self, scene: Scene, name: str) -> None:
        super().__init__(name=name, daemon=True)
        self.scene = scene
        self.chance = scene.random(name)

    def act(self) -> None:
        """Do one thing."""
        raise NotImplementedError

    def end(self) -> None:
        """Leave no client behind."""

    def run(self) -> None:
        try:
            while not self.scene.over.wait(self.chance.expovariate(1 / self.pause_s)):
                self.act()
            self.end()
        except Exception:
            if not self.scene.over.is_set():
                self.scene.troubles.append(f"{self.name}: {traceback.format_exc()}")


class Asker(Actor):
    """Verbs of the control socket that change something."""

    def __init__(self, scene: Scene, name: str) -> None:
        super().__init__(scene, name)
        self.runs = 0
        self.numbers: list[int] = []
        """Numbers of faults that this client began."""

    def device(self) -> str:
        return self.chance.choice(
            [*self.scene.profiles, "nobody"] if self.chance.random() < 0.02 else list(self.scene.profiles)
        )

    def act(self) -> None:
        weights = {
            self.do: 30,
            self.send: 10,
            self.inject: 10,
            self.clear: 5,
            self.pin: 4,
            self.set: 4,
            self.drive: 4,
            self.play: 8,
            self.run_document: 4,
            self.cancel: 2,
            self.reset: 2,
            self.reload: 1,
        }
        self.chance.choices(list(weights), list(weights.values()))[0]()

    def do(self) -> None:
        device = self.device()
        profile = self.scene.profiles.get(device, "sac")
        verb = self.chance.choice(inputs.verbs_of(profile))
        given = inputs.verb_parameters(self.chance, verb, profile)
        self.scene.ask("do", device=device, name=verb.name, parameters=given)

    def send(self) -> None:
        device = self.device()
        profile = self.scene.profiles.get(device, "sac")
        if profile == "sac" and self.chance.random() < 0.3:
            self.scene.ask("send", device=f"{device}.network", data=inputs.on_wire(self.chance).hex())
        else:
            self.scene.ask("send", device=device, data=inputs.typed(self.chance, profile).hex())

    def inject(self) -> None:
        kind = self.chance.choice(list(FAULT_KINDS.values()))
        target = self.chance.choice(targets(self.scene.config))
        given = inputs.fault_parameters(self.chance, kind)
        answer = self.scene.ask("inject", fault=kind.name, target=target, parameters=given)
        if answer:
            self.numbers.append(answer["number"])

    def clear(self) -> None:
        """Clear a fault, mostly one of its own: what others began is for them."""
        if self.numbers and self.chance.random() < 0.9:
            self.scene.ask("clear", number=self.numbers.pop(self.chance.randrange(len(self.numbers))))
        else:
            self.scene.ask("clear", number=self.chance.randint(0, 50))

    def pin(self) -> None:
        level = self.chance.randint(0, 1)
        self.scene.ask("pin", device=self.device(), pin=self.chance.choice(inputs.PINS), level=level)

    def set(self) -> None:
        field = self.chance.choice(inputs.SET_FIELDS)
        value = self.chance.choice((0, 1, 0.05, -0.3, 384, 99))
        self.scene.ask("set", device=self.device(), field=field, value=value)

    def drive(self) -> None:
        self.scene.ask("drive", device=self.device(), train=inputs.train(self.chance))

    def play(self) -> None:
        taps = [name for name in targets(self.scene.config) if name.startswith("bus")]
        tap = self.chance.choice([*taps, "bus0.a"])
        self.scene.ask("play", tap=tap, bursts=inputs.bursts(self.chance))

    def run_document(self) -> None:
        self.runs += 1
        text = inputs.run_document(self.chance, f"{self.name}-{self.runs}", axes(self.scene.config))
        self.scene.ask("run", text=text, file="soak.run.yaml", check=self.chance.random() < 0.1)

    def cancel(self) -> None:
        name = f"{self.name}-{self.chance.randint(0, self.runs)}"
        self.scene.ask("cancel_run", name=name, how=self.chance.choice(("grace", "prejudice")))

    def reset(self) -> None:
        self.scene.ask("reset", device=self.device())

    def reload(self) -> None:
        """Reload a wrong, a changed or the same configuration: a log holds one bench, so only the same may
        come out."""
        text = json.dumps(self.scene.config)
        match self.chance.randrange(3):
            case 0:
                text = json.dumps(changed(self.chance, self.scene.config))
            case 1:
                text = text[: self.chance.randint(0, len(text) - 1)]
        self.scene.file.write_text(text)
        done = self.scene.ask("reload")
        if done and any(done.get(what) for what in ("restarted", "added", "removed")):
            self.scene.troubles.append(f"a reload of a bench with a log changed it: {done}")


class Typist(Actor):
    """Opens a port, types and reads or does not read, and goes."""

    pause_s = 0.15

    def __init__(self, scene: Scene, name: str, address: str, profile: str) -> None:
        super().__init__(scene, f"typist at {name}")
        self.address = address.replace("rfc2217://", "socket://")
        self.profile = profile
        self.client: Client | None = None

    def act(self) -> None:
        with suppress(OSError):  # a terminal whose cable is out, a connection that was closed
            if self.client is None:
                self.client = Client(self.address)
                self.scene.counts["clients"] += 1
            chance = self.chance.random()
            if chance < 0.7:
                data = (
                    inputs.typed(self.chance, self.profile) if self.profile else inputs.on_wire(self.chance)
                )
                self.scene.counts["written"] += self.client.write_until_full(data)
            if chance < 0.9:
                self.scene.counts["read"] += len(self.client.quiet(0))
                return
        self.end()

    def end(self) -> None:
        if self.client:
            self.client.close()
            self.client = None


class Looker(Actor):
    """Asks for all that can be read, at odd moments."""

    pause_s = 0.05

    def __init__(self, scene: Scene, name: str) -> None:
        super().__init__(scene, name)
        self.watches: list[int] = []

    def act(self) -> None:
        chance, ask = self.chance, self.scene.ask
        device = chance.choice(list(self.scene.profiles))
        looks: tuple[Callable[[], object], ...] = (
            lambda: ask("status"),
            lambda: ask("segments"),
            lambda: ask("list"),
            lambda: ask("faults"),
            lambda: ask("runs", name=""),
            lambda: ask("verbs", device=device),
            lambda: self.watch(device),
            self.samples,
            self.samples,
            self.unwatch,
            self.scrape,
        )
        for _ in range(chance.choice((1, 1, 1, 20))):
            chance.choice(looks)()

    def watch(self, device: str) -> None:
        if len(self.watches) < 4:
            interval_ns = self.chance.choice((1, 2, 5, 10, 50, 1000)) * inputs.MS
            interval_ns += self.chance.choice((0, 0, 1, -1, self.chance.randrange(inputs.MS // 2)))
            answer = self.scene.ask("watch", device=device, signals=[], interval_ns=interval_ns)
            if answer:
                self.watches.append(answer["watch"])

    def samples(self) -> None:
        for watch in self.watches:
            self.scene.ask("samples", watch=watch)

    def unwatch(self) -> None:
        if self.watches:
            self.scene.ask("unwatch", watch=self.watches.pop())

    def scrape(self) -> None:
        self.scene.counts["scrapes"] += 1
        with suppress(OSError), urllib.request.urlopen(self.scene.metrics, timeout=ASK_S) as answer:
            answer.read()


class Subscriber(Actor):
    """A client over zenoh: set-points, parameters and faults, and subscriptions that come and go."""

    pause_s = 0.08
    TOPICS = ("axis/*/state", "axis/*/state/packed", "segment/*/packets", "port/*/tx", "port/*/rx", "sim/*")
    KEYS = ("sim/clock", "sim/health", "segment/bus0/stats", "axis/m1/state", "axis/m1/param/pKp")

    def run(self) -> None:
        with (
            suppress(ClientError),
            connect_sync(str(self.scene.config["bench"]), self.scene.zenoh) as self.bench,
        ):
            super().run()

    def act(self) -> None:
        chance, bench = self.chance, self.bench
        device = chance.choice(list(self.scene.profiles))
        axis = bench.axis(device)
        self.scene.counts["over zenoh"] += 1
        with suppress(ClientError):
            match chance.choice(("put", "put", "put", "read", "read", "set", "fault", "listen")):
                case "put":
                    for _ in range(chance.choice((1, 1, 10))):
                        self.put(device)
                case "read":
                    bench.read(chance.choice(self.KEYS))
                case "set":
                    axis.set_parameter(chance.choice(("pKp", "vKi", "PA", "load_torque_Nm")), chance.random())
                case "fault":
                    kind = chance.choice(list(FAULT_KINDS.values()))
                    axis.fault(kind.name, **inputs.fault_parameters(chance, kind))
                case "listen":
                    with bench.link.subscribe(chance.choice(self.TOPICS), self.heard):
                        self.scene.over.wait(chance.uniform(0, 2))

    def put(self, device: str) -> None:
        profile = self.scene.profiles[device]
        verbs = [verb for verb in inputs.verbs_of(profile) if verb.name in ("position", "velocity", "torque")]
        if not verbs:
            return
        verb = self.chance.choice(verbs)
        self.bench.axis("arm.forearm" if device == "arm" else device).put(
            verb.name, **inputs.verb_parameters(self.chance, verb, profile)
        )

    def heard(self, payload: bytes) -> None:
        self.scene.counts["heard"] += len(payload)


class Recorder(Actor):
    """Captures of ports and wires that are ended in the middle."""

    pause_s = 0.5

    def act(self) -> None:
        names = [name for name in targets(self.scene.config) if not name.endswith(".network")]
        ports = self.chance.sample(names, self.chance.randint(1, len(names)))
        with suppress(OSError), socket.socket(socket.AF_UNIX) as client:
            client.connect(str(self.scene.control))
            client.sendall(json.dumps({"verb": "capture", "ports": ports}).encode() + b"\n")
            client.settimeout(self.chance.uniform(0.01, 0.5))
            for _ in range(self.chance.randint(0, 50)):
                self.scene.counts["captured"] += len(client.recv(65536))


class Watcher:
    """Process of somebody's ``hil status --watch``."""

    def __init__(self, runtime: Path) -> None:
        command = [HIL, "status", "--watch", "--runtime-dir", str(runtime)]
        self._process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=os.environ | TERMINAL
        )

    def end(self) -> None:
        self._process.kill()
        self._process.wait()


def actors(scene: Scene) -> list[Actor]:
    """Make all clients of a bench, not started yet."""
    every: list[Actor] = [Asker(scene, "asker"), Asker(scene, "other"), Looker(scene, "looker")]
    every += [Subscriber(scene, "subscriber"), Recorder(scene, "recorder")]
    listed = scene.ask("list")
    for row in listed["devices"]:
        if row["address"] is None:
            continue
        every.append(Typist(scene, row["device"], row["address"], scene.profiles[row["device"]]))
        if row["network"]:
            every.append(Typist(scene, f"{row['device']}.network", row["network"], ""))
    taps = [row for row in listed["taps"] if row["tap"].startswith("bus") and not row["tap"].endswith(LINE)]
    every += [Typist(scene, row["tap"], row["port"], "") for row in taps]
    return every
