"""Search for the smallest set of faults with which something fails."""

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from hil.testing.seeds.smallest_faults import MOST_TRIES, find_smallest


@given(st.integers(1, 12), st.data())
def test_what_is_found_fails_and_no_part_of_it_does(count, data):
    faults = [f"f{number}" for number in range(count)]
    causes = data.draw(
        st.lists(st.sets(st.sampled_from(faults), min_size=1, max_size=3), min_size=1, max_size=3)
    )
    runs = []

    def fails(some):
        runs.append(list(some))
        return any(cause <= set(some) for cause in causes)

    found = find_smallest(faults, fails)
    assert fails(found.faults)
    assert [*found.faults] == [each for each in faults if each in found.faults]
    assert found.tries == len(runs) - 1 <= MOST_TRIES
    if found.is_proved:
        assert not any(fails(part) for part in combinations(found.faults, len(found.faults) - 1))
    else:
        assert found.tries == MOST_TRIES


def test_what_fails_without_faults_takes_one_run():
    assert find_smallest(["a", "b"], lambda some: True) == ((), True, 1)


def test_one_fault_alone_needs_no_search():
    assert find_smallest(["a"], lambda some: "a" in some) == (("a",), True, 1)


def test_a_set_that_was_found_before_is_tried_first():
    faults = [f"f{number}" for number in range(16)]
    assert find_smallest(faults, lambda some: "f3" in some, [("f9",), ("f3",)]) == (("f3",), True, 3)
    found = find_smallest(faults, lambda some: {"f3", "f9"} <= set(some), [("f3", "f4", "f9")])
    assert found.faults == ("f3", "f9")


def test_the_search_is_bounded():
    faults = list(range(100))
    found = find_smallest(faults, lambda some: len(some) >= 60)
    assert (found.tries, found.is_proved) == (MOST_TRIES, False)
    assert 60 <= len(found.faults) < 100
