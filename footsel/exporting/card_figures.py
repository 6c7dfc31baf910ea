"""The figures on a model card: over all validation maps, per terrain family, along the thresholds, and of reliability.

A network's figures are those that training keeps in its header (footsel.learning.scores); older ones have fewer.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from footsel.footholds import Reason
from footsel.legs import PAIRS

Figures = Mapping[str, Any]

_REASONS = (Reason.KINEMATIC_RANGE, Reason.SELF_COLLISION, Reason.TERRAIN_COLLISION)

#: Key path in a pair's figures -> row of the card's table, and the format of its value.
_ROWS: tuple[tuple[tuple[str, ...], str, str], ...] = (
    (("cells_likeliest", "accuracy"), "class accuracy, most probable of 14 classes (as the paper measures)", "{:.2%}"),
    (("cells_likeliest", "accuracy_feasible"), "the same of feasible cells alone", "{:.2%}"),
    (("cells_likeliest", "miou"), "mean IoU of the same, absent classes as 0", "{:.3f}"),
    (("cells_likeliest", "miou_present"), "mean IoU of the same, present classes", "{:.3f}"),
    (("cells", "accuracy"), "class accuracy by the selector's rule", "{:.2%}"),
    (("cells", "cost_mae"), "mean absolute cost error where both say feasible, of 255", "{:.2f}"),
    (("cells", "false_safe_rate"), "false safe: infeasible cells called feasible", "{:.2%}"),
    (("cells", "false_unsafe_rate"), "false unsafe: feasible cells called infeasible", "{:.2%}"),
    *(
        (("cells", "recall_by_reason", reason.name), f"{reason.name.lower().replace('_', ' ')} recognised", "{:.2%}")
        for reason in _REASONS
    ),
    (("picks", "infeasible_rate"), "picks that the oracle rejects", "{:.2%}"),
    *(
        (("picks", "infeasible_by_reason", reason.name), f"of them for {reason.name.lower().replace('_', ' ')}", "{:d}")
        for reason in _REASONS
    ),
    (("picks", "missed"), "no answer although there is a foothold, maps", "{:d}"),
    (("picks", "missed_rate"), "their share of the maps with a foothold", "{:.2%}"),
    (("picks", "regret_mean"), "mean regret of a pick, final cost", "{:.2f}"),
    (("picks", "regret_p95"), "95th percentile of the regret", "{:.1f}"),
    (("calibration", "infeasible", "ece"), "calibration error of p(infeasible), cells", "{:.2%}"),
    (("calibration", "likeliest", "ece"), "calibration error of the most probable class, cells", "{:.2%}"),
    (("calibration", "picks", "ece"), "calibration error of the picks' confidence", "{:.2%}"),
)

#: Every so many of the thresholds are shown, besides the one in use.
_THRESHOLD_STEP = 4
#: Picks' confidences are shown in these ranges, the last one up to 1.
_CONFIDENCES = (0.0, 0.9, 0.97, 0.99, 0.999)
#: A family is named as a weak spot if it is this many times as bad as all together.
_MUCH_WORSE = 2.0


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a Markdown table."""
    return ["| " + " | ".join(row) + " |" for row in (head, ("---",) * len(head), *rows)]


def overall(figures: Mapping[str, Figures]) -> list[str]:
    """figures: pair -> its figures, as in all below."""
    rows = [(label, *(_value(figures[pair], path, form) for pair in PAIRS)) for path, label, form in _ROWS]
    return table(("", *PAIRS), rows)


def by_family(figures: Figures) -> list[str]:
    """One pair's table of terrain families."""
    columns = (
        (("maps",), "maps", "{:d}"),
        (("cells_likeliest", "accuracy"), "accuracy", "{:.1%}"),
        (("cells_likeliest", "miou_present"), "mean IoU", "{:.3f}"),
        (("cells", "false_safe_rate"), "false safe", "{:.2%}"),
        (("picks", "picks"), "picks", "{:d}"),
        (("picks", "infeasible_rate"), "infeasible", "{:.2%}"),
        (("picks", "missed_rate"), "missed", "{:.2%}"),
        (("picks", "regret_mean"), "mean regret", "{:.1f}"),
    )
    everything = {"all": figures, **figures.get("families", {})}
    rows = [(name, *(_value(each, path, form) for path, _, form in columns)) for name, each in everything.items()]
    return table(("family", *(title for _, title, _ in columns)), rows)


def along_thresholds(figures: Figures, feasible_below: float) -> list[str]:
    """One pair's table of thresholds, the one in use in bold."""
    curve = figures.get("thresholds", [])
    columns = (
        ("feasible_below", "{:.3g}"),
        ("picks", "{:d}"),
        ("infeasible_rate", "{:.2%}"),
        ("missed_rate", "{:.2%}"),
        ("regret_mean", "{:.2f}"),
        ("regret_p95", "{:.1f}"),
        ("false_safe_rate", "{:.2%}"),
        ("false_unsafe_rate", "{:.2%}"),
    )
    rows = []
    for index, point in enumerate(curve):
        used = point["feasible_below"] == feasible_below
        if used or index % _THRESHOLD_STEP == 0:
            cells = [_value(point, (key,), form) for key, form in columns]
            rows.append([f"**{cell}**" for cell in cells] if used else cells)
    head = ("p(infeasible) below", "picks", "infeasible", "missed", "mean regret", "p95", "false safe", "false unsafe")
    return table(head, rows)


def confidences(figures: Mapping[str, Figures]) -> list[str]:
    """How often the oracle accepts a pick, by its confidence."""
    rows = []
    for low, high in zip(_CONFIDENCES, (*_CONFIDENCES[1:], 1.0), strict=True):
        cells = [f"{low:g} to {high:g}"]
        for pair in PAIRS:
            bins = _at(figures[pair], ("calibration", "picks", "bins")) or []
            # A bin belongs to the range that its mean lies in.
            inside = [b for b in bins if low <= b["probability"] < high or (high == 1.0 and b["probability"] == high)]
            count = sum(each["count"] for each in inside)
            mean = [sum(each["count"] * each[key] for each in inside) for key in ("probability", "frequency")]
            cells += [str(count), *(f"{each / count:.2%}" if count else "-" for each in mean)]
        rows.append(cells)
    head = ["confidence", *(f"{pair}{what}" for pair in PAIRS for what in (": picks", ", mean", ", accepted"))]
    return table(head, rows)


def weak_spots(figures: Mapping[str, Figures]) -> list[str]:
    """Sentences on the families where a pair rejects or misses much more than on all together."""
    lines = []
    for pair in PAIRS:
        for key, words in (("infeasible_rate", "picks that the oracle rejects"), ("missed_rate", "missed footholds")):
            whole = _at(figures[pair], ("picks", key))
            shares = {name: _at(each, ("picks", key)) for name, each in figures[pair].get("families", {}).items()}
            worse = {name: share for name, share in shares.items() if whole and share and share > _MUCH_WORSE * whole}
            if worse:
                named = ", ".join(f"{name} {worse[name]:.1%}" for name in sorted(worse, key=lambda each: -worse[each]))
                lines.append(f"- {pair}: {words} are {whole:.1%} of all, but {named}.")
    return lines


def _at(figures: Figures, path: Sequence[str]) -> Any:
    """The value at a path of keys, None where there is none."""
    value: Any = figures
    for key in path:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _value(figures: Figures, path: Sequence[str], form: str) -> str:
    value = _at(figures, path)
    return "-" if value is None else form.format(value)
