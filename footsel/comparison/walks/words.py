"""The figures of walks in plain words."""

from collections.abc import Mapping, Sequence
from typing import Any

from footsel.comparison.summary import counted, percent, short_names
from footsel.comparison.walks.figures import NETWORK, REFERENCE

#: Differences with a p-value above this may be chance.
SURE = 0.05


def opening(figures: Mapping[str, Any]) -> str:
    """What was walked."""
    runs = figures["runs"]
    terrains, selectors = (list(dict.fromkeys(run[key] for run in runs)) for key in ("terrain", "selector"))
    seeds = sorted({run["seed"] for run in runs})
    drawn = f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"
    seconds = sum(run["duration_s"] for run in runs)
    return (
        f"{counted(len(runs), 'walk')}: {counted(len(selectors), 'selector')} on {counted(len(terrains), 'terrain')}, "
        f"each on {counted(len(seeds), 'course')} of its own ({drawn}), the same for every "
        f"selector; {seconds / 60:.0f} minutes of walking. Only the choice of footholds differs."
        + ("" if figures["watch_limbs"] else " The planner does not keep thighs and shanks clear of the ground.")
    )


def about_selector(name: str, figures: Mapping[str, Any]) -> str:
    """Where a selector reached the goal and where not, and why not."""
    parts = {terrain: selectors[name] for terrain, selectors in figures["summary"].items() if name in selectors}
    shown = _shown(figures)
    n = sum(part["n"] for part in parts.values())
    reached = sum(successes(part) for part in parts.values())
    text = f"{name} reached the goal in {reached} of {counted(n, 'walk')}."
    failed = [terrain for terrain, part in parts.items() if part["success_rate"] < 1]
    if failed and reached:
        worst = min(failed, key=lambda terrain: parts[terrain]["success_rate"])
        text += f" It did worst on {shown[worst]}: {rate(parts[worst])}."
    reasons: dict[str, int] = {}
    for part in parts.values():
        for reason, count in part["failures"].items():
            reasons[reason] = reasons.get(reason, 0) + count
    if reasons:
        main = max(reasons, key=lambda reason: reasons[reason])
        text += f" What ended most of its failed walks: {main} ({reasons[main]} of {n - reached})."
    return text


def where_the_network_helps(figures: Mapping[str, Any]) -> list[str]:
    """Terrain by terrain, what the network's choices are worth against selectors without its knowledge."""
    shown = _shown(figures)
    sentences = []
    for terrain, others in figures["network_minus"].items():
        rivals = {name: difference for name, difference in others.items() if name not in (REFERENCE, "cnn+verify")}
        if rivals:
            sentences.append(_about_terrain(shown[terrain], figures["summary"][terrain], rivals))
    return sentences


def counts(part: Mapping[str, Any]) -> str:
    """How many walks reached the goal."""
    return f"{successes(part)} of {part['n']}"


def rate(part: Mapping[str, Any]) -> str:
    """A success rate with its interval."""
    low, high = part["ci95"]
    return f"{counts(part)} (95 % interval {percent(low)} to {percent(high)})"


def successes(part: Mapping[str, Any]) -> int:
    """Walks that reached the goal."""
    count: int = round(part["success_rate"] * part["n"])
    return count


def _about_terrain(terrain: str, summary: Mapping[str, Any], rivals: Mapping[str, Any]) -> str:
    surely = [name for name, d in rivals.items() if d["success"]["mean"] > 0 and _is_sure(d["success"])]
    maybe = [name for name, d in rivals.items() if d["success"]["mean"] > 0 and not _is_sure(d["success"])]
    without = [name for name, d in rivals.items() if d["success"]["mean"] <= 0]
    sentences = []
    if surely:
        sentences.append(
            f"On {terrain} the network reaches the goal more often than {joined(surely)}: "
            f"{rate(summary[NETWORK])} against {joined([rate(summary[name]) for name in surely])}."
        )
    if maybe:
        sentences.append(
            f"On {terrain} it reaches the goal more often than {joined(maybe)} in these walks, "
            "which may be chance: they are too few to tell."
        )
    if without:
        reached = joined([f"{name} {counts(summary[name])}" for name in (NETWORK, *without)])
        sentences.append(f"On {terrain} the network does not help to reach the goal: {reached}.")
    for metric, unit, what in (
        ("hind_shank_contact_s", "s", "hind shanks touch the ground"),
        ("shank_impacts", "", "hard impacts of shanks"),
    ):
        clear = {name: d[metric] for name, d in rivals.items() if d[metric] is not None and _is_sure(d[metric])}
        if clear:
            differences = [f"{name} {_signed(d['mean'], unit)}" for name, d in clear.items()]
            sentences.append(f"Of walks that both finish, {what}, network minus others: {joined(differences)}.")
    return " ".join(sentences)


def _is_sure(difference: Mapping[str, Any]) -> bool:
    return bool(difference["sign_test_p"] < SURE)


def _signed(value: float, unit: str) -> str:
    return f"{value:+.2f} {unit}".strip().replace("-", "−")


def joined(names: Sequence[str]) -> str:
    """a, b and c."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _shown(figures: Mapping[str, Any]) -> dict[str, str]:
    return short_names(list(figures["summary"]))
