"""Films by their laws: a point appears where the camera says, a film has all its pictures, and a failed one is gone."""

import av
import numpy as np
import pytest
from PIL import Image

from footsel.comparison import palette
from footsel.comparison.walks.film import Film, Still
from footsel.comparison.walks.film.camera import Camera
from footsel.comparison.walks.film.observers import HEIGHT, RATE, SPEED, WIDTH
from footsel.comparison.walks.film.painter import Painter, cost_map_image
from footsel.comparison.walks.film.stage import SKY, Stage
from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.selectors import make_selector
from footsel.terrain import ElevationMap
from footsel.walking.courses import make_walk_course
from footsel.walking.observer import Choice, Moment


@pytest.fixture(scope="module")
def robot():
    return load_robot()


@pytest.fixture(scope="module")
def selector():
    return make_selector("terrain_only")


@pytest.fixture(scope="module")
def course():
    return make_walk_course("blocks", 0)


@pytest.fixture(scope="module")
def moment_at(robot, selector, course):
    """moment_at(time, x) -> the standing robot at x on its way, choosing a foothold for LF."""
    joints = np.array([robot.description.stance[leg] for leg in LEGS], dtype=float).ravel()

    def make(time, x):
        pose = BasePose(x, 0, float(course.ground.sample([x, 0])) + 0.48, 0, 0, 0)
        base = np.eye(4)
        base[:3, 3] = pose.position
        feet = {leg: np.array([*selector.layout.nominal_xy(leg, pose), 0.05]) for leg in LEGS}
        foothold = selector.select(course.known, pose, ("LF",))["LF"]
        choice = Choice(time, "LF", pose, course.known, tuple(feet["LF"][:2]), foothold)
        polygon = np.array([feet[leg] for leg in ("RF", "RH", "LH")])
        return Moment(time, base, joints, "LF", feet, polygon, choice, None)

    return make


def test_the_focus_is_in_the_middle_and_the_span_fits():
    for yaw in (0.0, 1.2, -2.0):
        focus = np.array([1.0, -2.0, 0.3])
        camera = Camera.beside(focus, yaw, 3.0, 600, 300)
        np.testing.assert_allclose(camera.pixels(focus), [[300, 150]], atol=1e-6)
        ahead = np.array([np.cos(yaw), np.sin(yaw), 0])
        ends = camera.pixels([focus - 1.5 * ahead, focus + 1.5 * ahead])
        assert ends[0, 0] < 300 < ends[1, 0]  # The robot walks to the right.
        assert 450 < ends[1, 0] - ends[0, 0] <= 700
        assert camera.pixels(focus + np.array([0, 0, 0.1]))[0, 1] < 150


def test_the_renderer_and_the_camera_agree(robot):
    """Feet of the rendered robot are where `pixels` puts them."""
    ground = ElevationMap(np.full((60, 60), -5.0, dtype=np.float32), 0.02)
    camera = Camera.beside([0, 0, 0.2], 0.4, 1.8, 640, 400)
    stage = Stage(ground, robot, camera)
    joints = np.array([robot.description.stance[leg] for leg in LEGS], dtype=float).ravel()
    base = np.eye(4)
    base[2, 3] = 0.48
    picture = stage.render(base, joints).astype(int)
    stage.close()
    foot = robot.layout.nominal_feet["RF"] + base[:3, 3] + [0, 0, robot.description.foot_radius]
    x, y = np.rint(camera.pixels(foot)[0]).astype(int)
    colour = np.array([int(palette.LEG_COLOURS["RF"][i : i + 2], 16) for i in (1, 3, 5)])
    patch = picture[y - 2 : y + 3, x - 2 : x + 3].reshape(-1, 3)
    # Lit and shaded, but of the leg's hue: its strongest channel stays the strongest.
    assert (patch.argmax(axis=1) == colour.argmax()).all() and (np.abs(patch - SKY).sum(axis=1) > 60).all()
    below = camera.pixels(foot - [0, 0, 0.06])[0].astype(int)
    np.testing.assert_array_equal(picture[below[1], below[0]], SKY)


def test_ground_hides_the_robot_behind_it_and_not_before_it(robot):
    heights = np.zeros((150, 150), dtype=np.float32)
    heights[:, 10:25] = 1.5  # A wall on the camera's side.
    joints = np.array([robot.description.stance[leg] for leg in LEGS], dtype=float).ravel()
    base = np.eye(4)
    base[2, 3] = 0.48
    camera = Camera.beside([0, 0, 0.3], 0.0, 3.0, 320, 200)

    def robot_pixels(ground):
        stage = Stage(ground, robot, camera)
        away = base.copy()
        away[2, 3] = -50
        seen = (stage.render(base, joints) != stage.render(away, joints)).any(axis=-1).sum()
        stage.close()
        return seen

    assert robot_pixels(ElevationMap(heights, 0.02)) < 0.2 * robot_pixels(ElevationMap(np.zeros_like(heights), 0.02))


def test_what_is_drawn_in(selector, moment_at):
    camera = Camera.beside([1.5, 0, 0.2], 0, 4.0, WIDTH, HEIGHT)
    moment = moment_at(0.0, 1.5)
    blank = np.full((HEIGHT, WIDTH, 3), 128, dtype=np.uint8)
    painted = Painter(camera, selector, "").paint(blank, moment, [("RF", np.array([0.5, -0.25, 0.0]))])
    changed = (painted != blank).any(axis=-1)
    for point in (*moment.footholds.values(), moment.support_polygon.mean(axis=0), [0.5, -0.25, 0.0]):
        x, y = camera.pixels(point)[0].astype(int)
        assert changed[y, x]
    assert changed[10:190, -180:-10].mean() > 0.95  # The cost map.
    assert not changed[-40:, :200].any()


def test_the_cost_map_shows_infeasible_cells_and_the_pick(moment_at, selector):
    moment = moment_at(0.0, 1.5)
    image = np.asarray(cost_map_image(moment.choice, selector))
    assert image.shape == (40 * 4 + 20, 40 * 4 + 2, 3)
    ring = np.array([int(palette.MARKS["cnn"].colour[i : i + 2], 16) for i in (1, 3, 5)])
    rows, columns = np.nonzero((image == ring).all(axis=-1))
    i, j = moment.choice.foothold.cell
    assert abs(columns.mean() - ((40 - j - 0.5) * 4 + 1)) < 3
    assert abs(rows.mean() - ((40 - i - 0.5) * 4 + 19)) < 3


def test_a_film_has_all_its_pictures(tmp_path, course, robot, selector, moment_at):
    path = tmp_path / "w.mp4"
    with Film(path, course, robot, selector) as film:
        for k in range(41):
            film.see(moment_at(0.04 * k, 0.02 * k))
        assert not path.exists()
    assert [file.name for file in tmp_path.iterdir()] == ["w.mp4"]
    with av.open(str(path)) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        assert container.streams.video[0].average_rate == RATE
    assert len(frames) == 1 + int(1.6 / (SPEED / RATE))
    assert frames[0].shape == (HEIGHT, WIDTH, 3)
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 50


def test_a_film_of_a_walk_that_broke_off_is_gone(tmp_path, course, robot, selector, moment_at):
    with pytest.raises(RuntimeError), Film(tmp_path / "w.mp4", course, robot, selector) as film:
        film.see(moment_at(0, 0))
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_a_still_is_of_the_middle(tmp_path, course, robot, selector, moment_at):
    still = Still(tmp_path / "p.png", course, robot, selector)
    still.see(moment_at(0, 0.1))
    assert not (tmp_path / "p.png").exists()
    still.see(moment_at(1, course.goal[0] / 2 + 0.01))
    first = (tmp_path / "p.png").read_bytes()
    still.see(moment_at(2, course.goal[0] - 0.1))
    still.see_end(moment_at(3, course.goal[0]), None)
    assert (tmp_path / "p.png").read_bytes() == first
    assert Image.open(tmp_path / "p.png").size == (2 * WIDTH, 2 * HEIGHT)


def test_a_walk_that_ends_early_has_a_still_too(tmp_path, course, robot, selector, moment_at):
    still = Still(tmp_path / "p.png", course, robot, selector)
    still.see(moment_at(0, 0.1))
    still.see_end(moment_at(1, 0.2), None)
    assert (tmp_path / "p.png").exists()
