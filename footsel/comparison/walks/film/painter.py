"""What is drawn over a picture of a walk: support polygon, footholds, and the cost map of the last choice."""

from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from footsel.comparison import palette
from footsel.comparison.walks.film.camera import Camera
from footsel.footholds.cost import INFEASIBLE_COST
from footsel.footholds.request import prepare
from footsel.selectors import Selector
from footsel.walking.observer import Choice, Moment

Pixels = NDArray[np.uint8]

#: Of a picture of WIDTH: side of a cell of the cost map, and its distance from the picture's border. [px]
WIDTH, CELL, MARGIN = 960, 4, 10
SUPPORT, SUPPORT_EDGE = (255, 200, 40, 95), (255, 180, 0, 255)


class Painter:
    """Draws on pictures of one camera. selector: whose costs the inset shows."""

    def __init__(self, camera: Camera, selector: Selector, caption: str) -> None:
        self._camera, self._selector, self._caption = camera, selector, caption
        self._scale = max(round(camera.width / WIDTH), 1)
        self._inset: tuple[Choice, Image.Image] | None = None

    def paint(self, picture: Pixels, moment: Moment, trail: Sequence[tuple[str, NDArray[np.float64]]]) -> Pixels:
        """(height, width, 3) the picture with everything drawn in.

        trail: leg and contact point of earlier footholds, small.
        """
        image, margin = Image.fromarray(picture), MARGIN * self._scale
        draw = ImageDraw.Draw(image, "RGBA")
        if len(moment.support_polygon) > 2:
            corners = [tuple(point) for point in self._camera.pixels(moment.support_polygon)]
            draw.polygon(corners, fill=SUPPORT, outline=SUPPORT_EDGE)
        for leg, point in trail:
            self._dot(draw, point, 2, _rgb(palette.LEG_COLOURS[leg]))
        for leg, point in moment.footholds.items():
            self._dot(draw, point, 6 if leg == moment.swing_leg else 4, _rgb(palette.LEG_COLOURS[leg]), outlined=True)
        if moment.choice is not None:
            inset = self._cost_map(moment.choice)
            image.paste(inset, (image.width - inset.width - margin, margin))
        text = f"{self._caption}   {moment.time:.1f} s"
        draw.text((margin, margin), text, fill=_rgb(palette.INK), font=_font(15 * self._scale))
        return np.asarray(image)

    def _dot(
        self,
        draw: ImageDraw.ImageDraw,
        point: NDArray[np.float64],
        radius: int,
        colour: tuple[int, ...],
        outlined: bool = False,
    ) -> None:
        x, y = self._camera.pixels(point)[0]
        radius *= self._scale
        edge = (255, 255, 255) if outlined else None
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=colour, outline=edge)

    def _cost_map(self, choice: Choice) -> Image.Image:
        """The local map of the last choice from above, the robot facing up; made once for each choice."""
        if self._inset is None or self._inset[0] is not choice:
            self._inset = choice, cost_map_image(choice, self._selector, self._scale)
        return self._inset[1]


def cost_map_image(choice: Choice, selector: Selector, scale: int = 1) -> Image.Image:
    """What the selector thought of the cells of a choice, the nominal foothold (cross) and its pick (ring)."""
    side, mark = CELL * scale, 5 * scale
    request = prepare(selector.layout, choice.elevation_map, choice.pose, (choice.leg,), {choice.leg: choice.nominal})[
        0
    ]
    scores, local_map = selector.score(request), request.local_map
    cost = np.clip(np.asarray(scores.cost, dtype=np.float64) / INFEASIBLE_COST, 0, 1)
    colours = colormaps[palette.COST_MAP](cost)[..., :3]
    colours[~scores.feasible] = to_rgb(palette.INFEASIBLE)
    colours[~local_map.known] = to_rgb(palette.UNKNOWN)
    # x up and y to the left.
    cells = (255 * colours[::-1, ::-1]).astype(np.uint8)
    n = local_map.cells
    image = Image.fromarray(np.repeat(np.repeat(cells, side, axis=0), side, axis=1))
    draw = ImageDraw.Draw(image)

    def at(i: float, j: float) -> tuple[float, float]:
        return (n - j - 0.5) * side, (n - i - 0.5) * side

    offset = np.array(request.nominal[:2]) - local_map.hip[:2]
    c, s = np.cos(local_map.yaw), np.sin(local_map.yaw)
    i, j = np.array([c * offset[0] + s * offset[1], c * offset[1] - s * offset[0]]) / local_map.resolution + (n - 1) / 2
    x, y = at(i, j)
    for line in ((x - mark, y, x + mark, y), (x, y - mark, x, y + mark)):
        draw.line(line, fill=_rgb(palette.INK), width=2 * scale)
    if choice.foothold.cell is not None:
        x, y = at(*choice.foothold.cell)
        ring = (x - mark, y - mark, x + mark, y + mark)
        draw.ellipse(ring, outline=_rgb(palette.MARKS["cnn"].colour), width=3 * scale)
    answer = "" if choice.foothold.cell is not None else ": none"
    framed = Image.new("RGB", (image.width + 2 * scale, image.height + 20 * scale), (255, 255, 255))
    framed.paste(image, (scale, 19 * scale))
    text = f"cost under {choice.leg}{answer}"
    ImageDraw.Draw(framed).text((5 * scale, 2 * scale), text, fill=_rgb(palette.INK), font=_font(12 * scale))
    return framed


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in to_rgb(colour))
    return red, green, blue


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)
