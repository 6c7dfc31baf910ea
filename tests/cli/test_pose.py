"""--pose: every spelling of a float, and what `auto` stands for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footsel import ElevationMap
from footsel.cli.main import Parser
from footsel.cli.numbers import protect_negative_numbers
from footsel.cli.options import PoseArgument, add_pose
from footsel.errors import InputError

parser = Parser(prog="test", allow_abbrev=False)
add_pose(parser)
parser.add_argument("--other", action="store_true")


def parse(*words):
    return parser.parse_args(protect_negative_numbers(["--pose", *words])).pose


def spellings(value):
    """The ways to write a float that name exactly this value."""
    return [repr(value), f"{value!r}".upper(), f"{value:+.17g}", f"{value:.17e}", f"{value:.17E}", str(value)]


numbers = st.floats(-1e6, 1e6)


@given(st.tuples(*[numbers.flatmap(lambda v: st.tuples(st.just(v), st.sampled_from(spellings(v))))] * 6))
def test_every_spelling_is_read(written):
    pose = parse(*[word for _, word in written])
    assert pose == PoseArgument(*[value for value, _ in written])


@pytest.mark.parametrize(
    ("word", "value"),
    [("-1e-05", -1e-5), ("-.5", -0.5), ("+1", 1.0), ("-1.", -1.0), ("1E3", 1e3), ("-0", -0.0), ("-1_000.5", -1000.5)],
)
def test_odd_spellings_stand_anywhere(word, value):
    for place in range(6):
        words = ["0"] * 6
        words[place] = word
        assert list(vars(parse(*words)).values())[place] == value


@pytest.mark.parametrize("word", ["nan", "-nan", "inf", "-inf", "1e999", "-Infinity", "x", "", "1,5", "auto", "1e7"])
def test_what_is_no_number_is_named(word):
    with pytest.raises(InputError, match="X of --pose"):
        parse(word, "0", "0", "0", "0", "0")


@pytest.mark.parametrize("words", [("0",) * 5, ("0",) * 7, ("0", "0", "0", "0", "0", "--other")])
def test_another_count_is_refused(words):
    with pytest.raises(InputError):
        parse(*words)


def test_options_after_the_pose_are_options():
    args = parser.parse_args(protect_negative_numbers(["--pose", "-1", "-2", "auto", "0", "0", "-3", "--other"]))
    assert args.other and args.pose == PoseArgument(-1.0, -2.0, None, 0.0, 0.0, -3.0)


def test_auto_stands_on_the_median_under_the_feet(anymal_layout):
    elevation = np.full((200, 200), 0.3)
    elevation[:, :20] = 9.0  # Far from the feet.
    pose = parse("0.1", "0", "auto", "0", "0.1", "0.5").on(ElevationMap(elevation, 0.02), anymal_layout)
    assert pose.z == pytest.approx(0.3 + anymal_layout.standing_height)
    assert (pose.x, pose.y, pose.roll, pose.pitch, pose.yaw) == (0.1, 0.0, 0.0, 0.1, 0.5)


def test_auto_needs_known_ground(anymal_layout):
    elevation = np.full((200, 200), np.nan)
    elevation[:10] = 0.0
    with pytest.raises(InputError, match="Z is auto, but no ground is known"):
        parse("0", "0", "auto", "0", "0", "0").on(ElevationMap(elevation, 0.02), anymal_layout)


@pytest.mark.parametrize("z", ["auto", "0.5"])
def test_off_the_map_is_said_first(anymal_layout, z):
    with pytest.raises(InputError, match=r"x=7 y=0 is off the map"):
        parse("7", "0", z, "0", "0", "0").on(ElevationMap(np.full((100, 100), np.nan), 0.02), anymal_layout)
