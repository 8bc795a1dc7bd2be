"""A site from nothing, with the commands as they are typed: router, benches, users, a run, new lists."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from bench_sites import run, state_of
from e2e_support import HIL, PATIENCE_S, Place, Server, config, free_port, until

from hil.client import Bench, ClientError, CommandError, connect_sync

pytestmark = [pytest.mark.long, pytest.mark.thorough]

SAC = {"profile": "sac", "flash": {}}
MOVE = {"move": {"m1": 30.0, "lathe/m1": -20.0}}


class Lab:
    """Folder of a site, and those of its members at their computers."""

    def __init__(self, place: Place, *options: str) -> None:
        self.place, self.there = place, place.folder / "there"
        self.site("new", *options)

    def site(self, verb: str, *words: str) -> None:
        self.place.hil("zenoh", "site", verb, str(self.place.folder / "lab"), *words)

    def copy(self) -> None:
        """Bring all folders to their computers, as they are now."""
        for folder in ("router", "benches/*", "users/*"):
            for path in (self.place.folder / "lab").glob(folder):
                shutil.copytree(path, self.there / path.name, dirs_exist_ok=True)

    @contextmanager
    def router(self) -> Iterator[None]:
        command = [HIL, "zenoh", "router", "--site", str(self.there / "router")]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            assert process.stdout
            assert "Ctrl-C ends it" in process.stdout.readline()
            yield
        finally:
            process.terminate()
            process.communicate(timeout=PATIENCE_S)

    def launch(self, bench: str, **more: object) -> Server:
        zenoh = {"site": str(self.there / bench), **more}
        text = config(bench, 1, {"m1": {}, "s1": SAC}, bridges={"zenoh": zenoh})
        return self.place.launch(text, bench=bench)

    @contextmanager
    def client(self, user: str, bench: str = "mill") -> Iterator[Bench]:
        with connect_sync(bench, config=self.there / user / "zenoh.json") as opened:
            yield opened


def refused(attempt: Callable[[], object]) -> str:
    try:
        attempt()
    except ClientError as error:
        return str(error)
    return ""


def test_a_site_behind_a_router(place: Place) -> None:
    lab = Lab(place, "--router", "127.0.0.1", "--port", str(free_port()))
    lab.site("add-bench", "mill", "lathe", "--label", "rig=press")
    lab.site("add-user", "anna", "--role", "admin")
    lab.site("add-user", "otto", "--role", "operator@mill", "--role", "viewer@rig=press")
    lab.copy()
    with lab.router():
        mill, lathe = lab.launch("mill"), lab.launch("lathe")
        for server in (mill, lathe):
            server.started().ready().ask("do", device="m1", name="enable", parameters={})
        until(lambda: [row["bench"] for row in mill.ask("benches")] == ["lathe"], "a sight of the lathe")

        with lab.client("anna") as anna, lab.client("otto") as otto, lab.client("otto", "lathe") as at_lathe:
            assert otto.axis("m1").enable().effective_at_ns
            assert at_lathe.axis("m1").state().at_ns
            assert "nobody answers" in refused(at_lathe.axis("m1").enable)
            anna.submit(run("together", MOVE))
            until(lambda: state_of(mill, "together") in ("done", "failed"), "the run's end")
            assert state_of(mill, "together") == "done"
            # A bench that leads a run asks others for its user, not with its own rights.
            with pytest.raises(CommandError, match="role operator"):
                otto.submit(run("beyond", MOVE))

            file = lab.there / "otto/zenoh.json"
            otto_has = place.hil("lease", "take", "--why", "x", "--bench", "mill", "--config", str(file))
            assert otto_has.startswith("otto until ")
            with pytest.raises(CommandError, match="otto has this bench"):
                anna.axis("m1").enable()
            assert place.hil("lease", "give", "--bench", "mill", "--config", str(file)) == "given back\n"

            lab.site("change", "otto", "--role", "viewer@mill", "--role", "operator@lathe")
            lab.copy()
            until(lambda: not refused(at_lathe.axis("m1").enable), "the new list at router and lathe")
            until(lambda: refused(otto.axis("m1").enable), "the new list at the mill")
            lab.site("rotate")
            lab.site("remove", "otto")
            lab.copy()
            until(lambda: refused(at_lathe.axis("m1").state), "the list without otto")
            until(lambda: not refused(anna.axis("m1").enable), "anna again, by the certificate that she had")
        with lab.client("anna", "lathe") as anna:
            assert anna.axis("m1").enable().effective_at_ns
        for server in (mill, lathe):
            until(lambda at=server: "took list 7 of the site lab" in at.output, "the list at each bench")
            server.stop()


def test_a_bench_of_a_site_that_listens_itself(place: Place) -> None:
    lab, door = Lab(place), f"tls/127.0.0.1:{free_port()}"
    lab.site("add-bench", "mill", "--host", "127.0.0.1")
    lab.site("add-user", "otto", "--role", "viewer")
    lab.copy()
    file = lab.there / "otto/zenoh.json"

    def enables() -> bool:
        Path(file).write_text(file.read_text().replace("tls/127.0.0.1:7447", door))
        with lab.client("otto") as otto:
            return not refused(otto.axis("m1").enable)

    mill = lab.launch("mill", listen=[door]).started().ready()
    assert not enables()
    lab.site("change", "otto", "--role", "operator")
    lab.copy()
    until(enables, "the new list")
    lab.site("remove", "otto")
    shutil.copy(place.folder / "lab/members", lab.there / "mill")
    until(lambda: refused(enables), "the list without otto")
    assert "took list 5 of the site lab" in mill.stop()
