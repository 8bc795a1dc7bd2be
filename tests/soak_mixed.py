"""Mixed soak: everything at once, at random, in real time; then the replay, which must say identical.

Each seed makes a bench and its clients of chance: verbs, faults, bytes at ports and taps, resets, pins,
loads, reloads, runs, set-points, captures, drawings, pages that read or do not, masters of a CAN bus, a real
line that echoes, and watchers at odd intervals. Then the daemon is stopped, or killed, and its log is
replayed. All that the program chooses comes from the seed; when it happens is the machine's. A seed that went
wrong leaves its folder behind and says how to do it again. Beside them one bench runs all the time, with bad
pages and watchers alone: its memory afterwards is that of before.

    python tests/soak_mixed.py            five minutes, as `make soak-mixed`
    python tests/soak_mixed.py 3600       an hour
    python tests/soak_mixed.py --seed 7   one seed
"""

import argparse
import dataclasses
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parent))

from e2e_support import FAULTS_OF_OURS, HIL, PATIENCE_S, Place, Server
from soak_benches import random_bench
from soak_clients import Scene, Watcher, actors
from soak_doors import Drawer, EchoingAdapter, can_masters, pages
from soak_memory import MemorySoak

os.environ["HIL_CHECK_INPUTS"] = "1"  # in daemons: an input that no replay would take is an error
SEED_S = 25.0
KILLED_SHARE = 0.25
"""Share of the seeds whose daemon is killed; its log is cut."""
AT_ONCE = 2
REPLAY_S = 600.0
LOG = "inputs.log"
KINDS = ("asker", "typist", "looker", "subscriber", "recorder", "watcher", "page", "canmaster", "drawer")
"""Kinds of clients. A difference that goes with one of them is its doing."""


@dataclasses.dataclass
class Outcome:
    """Outcome of one seed."""

    seed: int
    boards: str = ""
    inputs: int = 0
    bytes: int = 0
    states: int = 0
    asked: int = 0
    refused: int = 0
    over_zenoh: int = 0
    stopped: int = 0
    """Number of times that the guard or a bug stopped a board."""
    is_killed: bool = False
    """True if the daemon was killed, and did not stop orderly."""
    troubles: list[str] = dataclasses.field(default_factory=list)
    kept: str = ""


def run_seed(seed: int, seconds: float, place: Place, without: Collection[str] = ()) -> Outcome:
    """Run one bench with all its clients for so long, and its replay. ``without``: kinds of clients."""
    chance = Random(seed)
    name = f"soak{seed}"
    port = 10_000 + 4 * os.getpid() % 20_000  # below those that the kernel gives to others
    adapter = EchoingAdapter(chance, place.folder)
    config = random_bench(chance, name, port, adapter.path)
    adapter.start()
    log = place.folder / LOG
    server = place.serve(json.dumps(config), "--log", str(log), bench=name)
    scene = Scene(
        seed,
        config,
        place.folder / f"{name}.yaml",
        server.control,
        f"tcp/127.0.0.1:{port + 1}",
        f"http://127.0.0.1:{port}/metrics",
    )
    clients = [*actors(scene), *pages(scene, f"http://127.0.0.1:{port + 2}/ws"), Drawer(scene, "drawer")]
    clients += can_masters(scene)
    every = [actor for actor in clients if type(actor).__name__.lower() not in without]
    screen = None if "watcher" in without else Watcher(place.runtime)
    for actor in every:
        actor.start()
    scene.over.wait(seconds)
    died = server.process.poll() is not None
    troubles = list(scene.troubles)
    is_killed = Random(f"{seed} end").random() < KILLED_SHARE
    if is_killed:
        server.kill()
    else:
        stop(server, troubles)
    scene.over.set()
    if screen:
        screen.end()
    for actor in every:
        actor.join(PATIENCE_S)
    adapter.end()
    (place.folder / "output").write_text(server.output)
    (place.folder / "config.json").write_text(json.dumps(config, indent=1))
    if died:
        troubles.insert(0, "the daemon ended by itself")
    troubles += [f"{word!r} in the daemon's log" for word in FAULTS_OF_OURS if word in server.output]
    outcome = Outcome(seed, _boards(config), asked=scene.counts["asked"], refused=scene.counts["refused"])
    outcome.over_zenoh = scene.counts["over zenoh"]
    outcome.stopped = server.output.count(" stopped: ")
    outcome.troubles, outcome.is_killed = troubles, is_killed
    check_replay(log, outcome)
    return outcome


def stop(server: Server, troubles: list[str]) -> None:
    """Stop the daemon by SIGTERM, which must work."""
    server.process.terminate()
    try:
        code = server.process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        troubles.append(f"the daemon did not end {PATIENCE_S:g} s after SIGTERM")
        server.kill()
    else:
        if code:
            troubles.append(f"the daemon's exit code is {code}")


def check_replay(log: Path, outcome: Outcome) -> None:
    """Replay a log by ``hil replay``, and note what it says."""
    try:
        done = subprocess.run(
            [HIL, "replay", str(log)], capture_output=True, text=True, timeout=REPLAY_S, check=False
        )
    except subprocess.TimeoutExpired:
        outcome.troubles.append(f"the replay did not end within {REPLAY_S:g} s")
        return
    said = (done.stdout + done.stderr).strip()
    (log.parent / "replay").write_text(said + "\n")
    if not said.startswith("identical: "):
        outcome.troubles.append(said)
        return
    if (" where the log ends" in said) != outcome.is_killed:
        outcome.troubles.append(f"the log of a daemon that was killed: {outcome.is_killed}, and: {said}")
    words = said.split()
    outcome.inputs, outcome.bytes, outcome.states = int(words[1]), int(words[3]), int(words[8])


def _boards(config: dict[str, object]) -> str:
    devices, segments = config["devices"], config["segments"]
    assert isinstance(devices, dict)
    assert isinstance(segments, dict)
    servos = sum(each["profile"] == "mechaduino" for each in devices.values())
    return f"{servos}+{len(devices) - servos}/{len(segments)}"


def keep(place: Place, seed: int) -> str:
    """Keep a copy of the folder without its sockets, and return its path."""
    kept = Path(tempfile.mkdtemp(prefix=f"hil-soak-{seed}-"))
    for path in place.folder.iterdir():
        if path.is_file():
            shutil.copy(path, kept)
    return str(kept)


def one(seed: int, seconds: float, without: Collection[str]) -> Outcome:
    """Run a seed, and keep its folder if it went wrong."""
    with Place() as place:
        try:
            outcome = run_seed(seed, seconds, place, without)
        except Exception as error:  # of this program: the others are still worth running
            outcome = Outcome(seed, troubles=[f"the soak itself: {error!r}"])
        if outcome.troubles:
            outcome.kept = keep(place, seed)
        return outcome


HEAD = "  seed  boards  inputs    bytes  states   asked refused   zenoh  stopped  replay"


def row(outcome: Outcome) -> str:
    """A line of the table, and what went wrong below it."""
    o = outcome
    line = f"{o.seed:6}  {o.boards:>6}  {o.inputs:6}  {o.bytes:7}  {o.states:6}  {o.asked:6}  {o.refused:6}  "
    line += f"{o.over_zenoh:6}  {o.stopped:7}  "
    line += "TROUBLE" if o.troubles else "identical, cut" if o.is_killed else "identical"
    rest = [f"        {trouble}" for trouble in o.troubles]
    if o.troubles:
        rest.append(f"        kept in {o.kept}; again: {sys.executable} tests/soak_mixed.py --seed {o.seed}")
    return "\n".join([line, *rest])


def in_process_of_its_own(seed: int, seconds: float, without: Collection[str]) -> Outcome:
    """Run a seed in a process of its own, so that what it leaves behind does not touch the next."""
    command = [sys.executable, __file__, "--seed", str(seed), "--each", str(seconds), "--json"]
    command += ["--without", *without] if without else []
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    try:
        return Outcome(**json.loads(done.stdout.splitlines()[-1]))
    except (ValueError, IndexError, TypeError):
        return Outcome(seed, troubles=[f"the soak itself: {done.stdout}{done.stderr}"])


def soak(first: int, seconds: float, each_s: float, at_once: int, without: Collection[str]) -> list[Outcome]:
    """Run seeds from ``first`` on until the time is over, beside a bench whose memory is looked at."""
    with Place() as place:
        memory = MemorySoak(place, 30_000 + 2 * os.getpid() % 2_000, seconds)
        memory.start()
        outcomes = _seeds(first, seconds, each_s, at_once, without)
        memory.end()
        print(memory.said)
        if memory.troubles or memory.is_alive():
            outcomes.append(Outcome(0, troubles=[memory.said, *memory.troubles], kept=keep(place, 0)))
            print(row(outcomes[-1]))
    return outcomes


def _seeds(
    first: int, seconds: float, each_s: float, at_once: int, without: Collection[str]
) -> list[Outcome]:
    outcomes: list[Outcome] = []
    until_s = time.monotonic() + seconds
    lock = threading.Lock()
    seeds = iter(range(first, 1 << 60))

    def work(_: int) -> None:
        while time.monotonic() < until_s:
            with lock:
                seed = next(seeds)
            outcome = in_process_of_its_own(seed, each_s, without)
            with lock:
                outcomes.append(outcome)
                print(row(outcome), flush=True)

    print(HEAD, flush=True)
    with ThreadPoolExecutor(at_once) as pool:
        list(pool.map(work, range(at_once)))
    return outcomes


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("seconds", nargs="?", type=float, default=300.0)
    parser.add_argument("--seed", type=int, help="only this one")
    parser.add_argument("--first", type=int, default=1, help="the first seed")
    parser.add_argument("--each", type=float, default=SEED_S, help="seconds of each seed")
    parser.add_argument("--at-once", type=int, default=AT_ONCE)
    parser.add_argument(
        "--without", nargs="+", default=[], metavar="KIND", help="leave out " + ", ".join(KINDS)
    )
    parser.add_argument("--json", action="store_true", help="of --seed, for programs")
    given = parser.parse_args()
    if given.seed is not None:
        outcomes = [one(given.seed, given.each, given.without)]
        print(json.dumps(dataclasses.asdict(outcomes[0])) if given.json else f"{HEAD}\n{row(outcomes[0])}")
    else:
        outcomes = soak(given.first, given.seconds, given.each, given.at_once, given.without)
        wrong = [str(outcome.seed) for outcome in outcomes if outcome.troubles]
        print(
            f"{len(outcomes)} seeds, {sum(o.inputs for o in outcomes)} inputs, "
            f"{sum(o.bytes for o in outcomes)} bytes from boards, {sum(o.asked for o in outcomes)} requests: "
            + (f"{len(wrong)} went wrong: {', '.join(wrong)}" if wrong else "each replay was identical")
        )
    raise SystemExit(any(outcome.troubles for outcome in outcomes))


if __name__ == "__main__":
    main()
