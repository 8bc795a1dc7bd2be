"""What the words of canonical motions promise to those who plan them."""

from hil.gcode.canonical import PLANE_AXES, Point


def test_the_axes_of_a_plane_and_the_one_across_are_right_handed() -> None:
    for axes in PLANE_AXES.values():
        assert sorted(axes) == [0, 1, 2]
        first, second, across = axes
        assert (second - first) % 3 == 1
        assert (across - second) % 3 == 1


def test_a_plane_is_named_by_its_axes() -> None:
    for plane, (first, second, _) in PLANE_AXES.items():
        assert sorted(plane) == sorted((Point._fields[first], Point._fields[second]))
