"""The mixed soak, a short one; and that it sees what it is made to see."""

from random import Random

import pytest
from e2e_support import Place
from soak_benches import random_bench
from soak_inputs import run_document, typed
from soak_mixed import LOG, Outcome, check_replay, run_seed


@pytest.mark.thorough
def test_a_short_one_and_a_log_that_lacks_an_input(place: Place) -> None:
    outcome = run_seed(5, 4, place, without=["watcher"])
    assert outcome.troubles == [], (place.folder / "output").read_text()
    assert outcome.bytes > 0
    assert outcome.asked > outcome.refused
    log = place.folder / LOG
    head, *lines = log.read_text().splitlines(keepends=True)
    sent = next(line for line in lines if '"sent":' in line and '"state":null' not in line)
    lines.remove(sent)
    log.write_text("".join([head, *lines]))
    check_replay(log, outcome)
    assert "lines have to stand before this one" in outcome.troubles[0]


@pytest.mark.thorough
def test_a_seed_says_all_that_is_chosen() -> None:
    def choices(seed: int) -> list[object]:
        random = Random(seed)
        config = random_bench(random, "t", 1)
        return [config, run_document(random, "r", list(config["devices"])), typed(random, "sac")]

    for seed in range(100):
        assert choices(seed) == choices(seed)
    assert choices(1) != choices(2)


def test_what_is_no_replay_is_a_trouble(place: Place) -> None:
    outcome = Outcome(1)
    check_replay(place.write("{}\n"), outcome)
    assert len(outcome.troubles) == 1
