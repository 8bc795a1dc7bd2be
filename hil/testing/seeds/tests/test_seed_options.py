"""Options of many seeds, and what is wrong with them."""

import pytest

from hil.testing.seeds.seed_options import Shard, one_seed, seeds_given, shard_given, window_given
from hil.testing.seeds.seed_run import parts_of


def test_seeds_are_a_number_of_them_or_a_range():
    assert seeds_given("1000") == range(1000)
    assert seeds_given("1") == range(1)
    assert seeds_given("2000..2999") == range(2000, 3000)
    assert one_seed("17") == range(17, 18)
    assert shard_given("3/40") == Shard(3, 40)
    assert [window_given(each) for each in ("2ms", "500us", "0.5 s", "0ms")] == [2, 0.5, 500, 0]


@pytest.mark.parametrize(
    ("read", "text", "why"),
    [
        (seeds_given, "0", "'0' has no seeds"),
        (seeds_given, "9..8", "has no seeds"),
        (seeds_given, "abc", "seeds are a number of them, as 1000, or from..to, as 2000..2999; not 'abc'"),
        (seeds_given, "-3", "not '-3'"),
        (seeds_given, "", "not ''"),
        (seeds_given, "1e3", "not '1e3'"),
        (seeds_given, "1000001", "at most 1000000 seeds"),
        (seeds_given, "4294967295..4294967296", "below 2\\*\\*32"),
        (one_seed, "3..4", "a seed is a whole number, as 17; not '3..4'"),
        (one_seed, "-1", "not '-1'"),
        (shard_given, "5/4", "there is no shard 5/4: they are 1/4 to 4/4"),
        (shard_given, "0/4", "there is no shard 0/4"),
        (shard_given, "0/0", "there is no shard 0/0: they are at least 1/1"),
        (shard_given, "3", "a shard is its number and how many there are, as 3/40; not '3'"),
        (window_given, "2", "a window of arrival is a time with its unit"),
        (window_given, "2min", "not '2min'"),
        (window_given, "61s", "at most 60 s"),
    ],
)
def test_mistakes_are_told_in_a_sentence(read, text, why):
    with pytest.raises(ValueError, match=why):
        read(text)


@pytest.mark.parametrize(
    ("node_id", "test", "seed"),
    [
        ("t.py::test_y[seed-17]", "t.py::test_y", 17),
        ("t.py::test_y[a-seed-0]", "t.py::test_y[a]", 0),
        ("t.py::test_y[a-seed-0-b]", "t.py::test_y[a-seed-0-b]", None),
        ("t.py::test_y", "t.py::test_y", None),
        ("t.py::test_y[x\ny-seed-4]", "t.py::test_y[x\ny]", 4),
    ],
)
def test_a_node_id_has_its_test_and_seed(node_id, test, seed):
    assert parts_of(node_id) == (test, seed)
