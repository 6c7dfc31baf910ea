"""Make the figures of our pages, and the words of the oracle that go with one of them.

docs/figures/result.png: footholds by the released network, and its costs beside the oracle's under one leg.
docs/figures/walk.png: the picture of `footsel walk`.
docs/figures/label.png and docs/results/label.txt: what `footsel label` draws and says of a leg's local map.
"""

import contextlib
import io
import os
import shlex
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from footsel.cli.main import main as footsel
from footsel.comparison import palette, panels
from footsel.footholds import BasePose
from footsel.footholds.request import prepare
from footsel.oracle import Oracle
from footsel.selectors import make_selector
from footsel.terrain.courses import make_course

DOCS = Path(__file__).resolve().parent
FAMILY, SEED, LEG = "rubble", 100, "LF"
X, Y, YAW = 0.3, -0.2, 0.5

#: Makes the map of the second figure, and the command that explains a cell of it.
COURSE = "from footsel.terrain.courses import make_course; make_course('blocks', 3).save('blocks.npz')"
LABEL = "footsel label blocks.npz --leg LF --pose 0.3 -0.2 auto 0.05 -0.1 0.5 --cell 22 24 --plot label.png"
#: The walk that is drawn half way, and how wide its picture is here.
WALK = "footsel walk --terrain stones --selector cnn --seed 0 --picture walk.png"
WALK_WIDTH = 960
#: Colours of these pictures, which are few.
COLOURS = 256


def main() -> None:
    """Draw all figures."""
    draw_result(DOCS / "figures" / "result.png")
    draw_walk(DOCS / "figures" / "walk.png")
    draw_label(DOCS / "figures" / "label.png", DOCS / "results" / "label.txt")


def draw_label(figure: Path, words: Path) -> None:
    """Run the commands as a user does."""
    with elsewhere():
        exec(COURSE, {})
        said = run(LABEL)
        picture = Image.open("label.png").convert("RGB")
    save(picture, figure)
    words.write_text(f'$ python -c "{COURSE}"\n$ {LABEL}\n{said}', encoding="utf-8")


def draw_walk(figure: Path) -> None:
    """Run the command as a user does."""
    with elsewhere():
        run(WALK)
        picture = Image.open("walk.png").convert("RGB")
    height = round(picture.height * WALK_WIDTH / picture.width)
    save(picture.resize((WALK_WIDTH, height), Image.Resampling.LANCZOS), figure)


@contextlib.contextmanager
def elsewhere() -> Iterator[None]:
    """In an empty folder."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def run(command: str) -> str:
    """What a command of ours prints."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        footsel(shlex.split(command)[1:])
    return said.getvalue()


def save(picture: Image.Image, path: Path) -> None:
    """With few colours, which keeps the repository small."""
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def draw_result(path: Path) -> None:
    """Draw the selection from above, and below it the cells of one leg."""
    course = make_course(FAMILY, SEED)
    cnn, oracle = make_selector("cnn"), Oracle.load()
    layout = cnn.layout
    pose = BasePose(X, Y, layout.ground_height(course, X, Y, YAW) + layout.standing_height, 0.0, 0.0, YAW)
    footholds = cnn.select(course, pose, top_k=4)
    (request,) = prepare(layout, course, pose, (LEG,))
    local_map, scores = request.local_map, cnn.score(request)
    label = oracle.label(local_map, LEG)

    cells = panels.new_figure(10.2, 2.9)
    drawings = {
        f"terrain under {LEG} [m]": lambda axes: panels.draw_terrain(axes, local_map),
        "cost by the network": lambda axes: panels.draw_cost(axes, local_map, scores.cost, scores.feasible),
        "cost by the oracle": lambda axes: panels.draw_cost(axes, local_map, label.cost, label.feasible),
        "the oracle's reasons": lambda axes: panels.draw_reasons(axes, local_map, label.reason),
    }
    for axes, (title, draw) in zip(cells.subplots(1, len(drawings)), drawings.items(), strict=True):
        draw(axes)
        axes.set_title(title, fontsize=panels.TITLE_SIZE)
        panels.mark_point(axes, panels.in_heading(local_map, np.array(request.nominal[:2])), palette.NOMINAL_POINT)
        panels.mark_picks(axes, local_map, {"cnn": footholds[LEG].cell})

    above = panels.selection_figure(course, pose, footholds, layout)
    parts = [Image.open(io.BytesIO(panels.png_bytes(figure, dpi=110))).convert("RGB") for figure in (above, cells)]
    whole = Image.new("RGB", (max(part.width for part in parts), sum(part.height for part in parts)), "white")
    top = 0
    for part in parts:
        whole.paste(part, ((whole.width - part.width) // 2, top))
        top += part.height
    path.parent.mkdir(parents=True, exist_ok=True)
    whole.save(path, optimize=True)


if __name__ == "__main__":
    main()
