"""``hil stop --site``: all benches of a site stop by one command, and it says which have."""

import json
from collections.abc import Iterator

import pytest
from bench_sites import FAR, Site, on_the_way, run, side_by_side, submit
from e2e_support import Place, ended


@pytest.fixture
def site() -> Iterator[Site]:
    with Place() as place, side_by_side(place) as made:
        yield made


def test_all_benches_stop_by_a_door_and_by_a_bench(site: Site) -> None:
    mill, lathe = site.two()
    where = ("--runtime-dir", str(site.place.runtime))
    submit(mill, run("r", FAR))
    on_the_way(lathe)
    said = site.place.cli("stop", "--site", "--connect", site.addresses["mill"], "--timeout", "30")
    lines = said.splitlines()
    assert [line.partition(" after ")[0] for line in lines[:2]] == ["lathe: confirmed", "mill: confirmed"]
    assert "run r cancelled" in said
    assert lines[2] == "2 of 2 benches have confirmed"
    assert ended(mill, "r")["state"] == "cancelled"
    assert ended(lathe, "r")["state"] == "cancelled"

    again = json.loads(site.place.cli("stop", "--site", "--json", "-b", "mill", "--timeout", "30", *where))
    assert [(row["bench"], row["state"]) for row in again["benches"]] == [
        ("mill", "confirmed"),
        ("lathe", "confirmed"),
    ]
    assert [row["stopped"] for row in again["benches"]] == [[], []]
    events = lathe.ask("events", after=0)["events"]
    assert [event for event in events if "nothing moved" in str(event)], events
    lathe.kill()
    site.part()
    alone = mill.ask("stop_site", how="grace", within_s=0.3)["benches"]
    assert [(row["bench"], row["state"]) for row in alone] == [("mill", "confirmed")]
    said = site.place.cli("stop", "--site", "--connect", site.addresses["mill"], "--timeout", "0.3", code=1)
    assert said.startswith("hil: ")
    assert "are of --site" in site.place.cli("stop", "--config", "a.json", code=2)
    assert "leave out the axes" in site.place.cli("stop", "m1", "--site", code=2)
