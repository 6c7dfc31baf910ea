"""The figures of a comparison in plain words."""

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Any

from footsel.footholds import DISTANCE_WEIGHT

#: Fewer picks than this make no rate worth naming.
ENOUGH_PICKS = 20

WHAT_FAILS = {
    "UNKNOWN": "no height is known there",
    "KINEMATIC_RANGE": "the leg does not reach there",
    "SELF_COLLISION": "the leg would hit the robot itself",
    "TERRAIN_COLLISION": "thigh or shank would hit the terrain",
}


def opening(figures: Mapping[str, Any]) -> str:
    """What was asked, and how often there was an answer."""
    asked, answerable, maps = figures["asked"], figures["answerable"], len(figures["maps"])
    where = f"{counted(maps, 'map')}, with {counted(figures['poses'], 'base pose')} each"
    return (
        f"On {where}, every selector was asked for a foothold of all four legs: {asked:,} questions. The oracle, which "
        f"checks every cell exactly, finds one in {answerable:,} of them ({percent(answerable / asked)})."
    )


def about_selector(name: str, figures: Mapping[str, Any]) -> str:
    """How a selector did against the oracle, in all."""
    picks = figures["selectors"][name]
    if not picks["picks"]:
        return f"{name} never found a foothold and missed {picks['missed']:,} of {figures['answerable']:,} that exist."
    sentences = [_about_infeasible(name, picks, figures["infeasible_pick_reasons"][name])]
    if picks["missed"]:
        share = percent(picks["missed"] / figures["answerable"])
        sentences.append(f"It found nothing for {counted(picks['missed'], 'leg')} that had a foothold ({share}).")
    else:
        sentences.append("It found a cell for every leg that had a foothold.")
    if picks["regret_mean"] is not None:
        sentences.append(
            f"Its other picks cost {picks['regret_mean']:.1f} more than the best cell on average, as much as stepping "
            f"{distance(picks['regret_mean'])} further from the nominal foothold; one in twenty costs over "
            f"{picks['regret_p95']:.0f} more."
        )
    return " ".join(sentences)


def weak_sides(name: str, figures: Mapping[str, Any]) -> str:
    """Where a selector does worse than on average: the map, the leg, and the constraint that a network sees least."""
    sentences = []
    overall = figures["selectors"][name]["infeasible_rate"] or 0.0
    for place, parts in (("on the map", figures["per_map"]), ("for the leg", figures["per_leg"])):
        rates = {
            part: values["selectors"][name]["infeasible_rate"]
            for part, values in parts.items()
            if values["selectors"][name]["picks"] >= ENOUGH_PICKS
        }
        if len(rates) > 1 and max(rates.values()) > overall:
            worst = max(rates, key=lambda part: rates[part])
            short = short_names(figures["maps"]).get(worst, worst)
            sentences.append(f"{place} {short} ({percent(rates[worst])} of its picks)")
    text = f"Infeasible picks of {name} are most frequent {' and '.join(sentences)}." if sentences else ""
    recalls = figures["cells"][name]["recall_by_reason"] if name in figures["cells"] else {}
    seen = {reason: share for reason, share in recalls.items() if share is not None and reason != "FEASIBLE"}
    if seen:
        least = min(seen, key=lambda reason: seen[reason])
        text += (
            f" Of all cells that it must refuse, it recognises those where {WHAT_FAILS[least]} least: "
            f"{percent(seen[least])} of them."
        )
    return text.strip()


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Map -> its name without folders, where that is enough to tell it from the others."""
    last = [PurePath(name).name for name in names]
    return {name: short if last.count(short) == 1 else name for name, short in zip(names, last, strict=True)}


def about_time(figures: Mapping[str, Any], jobs: int) -> str:
    """How long each selector takes."""
    times = ", ".join(f"{name} {values['time_ms']['p50']:.1f} ms" for name, values in figures["selectors"].items())
    many = (
        ""
        if jobs == 1
        else " Several processes shared the machine meanwhile; footsel bench measures on a core of its own."
    )
    return f"Four legs take (median): {times}.{many}"


def percent(share: float | None) -> str:
    """A share as a reader likes it: two digits that mean something."""
    if share is None:
        return "–"
    if share in (0.0, 1.0):
        return f"{share:.0%}".replace("%", " %")
    digits = 2 if share < 0.0095 else 1
    return f"{share * 100:.{digits}f} %"


def distance(cost: float) -> str:
    """The distance from the nominal foothold that costs as much."""
    return f"{cost / DISTANCE_WEIGHT * 100:.1f} cm"


def counted(count: int, noun: str) -> str:
    """A number with its noun."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def _about_infeasible(name: str, picks: Mapping[str, Any], reasons: Mapping[str, int]) -> str:
    number, total = picks["infeasible_picks"], picks["picks"]
    if not number:
        return f"None of the {total:,} picks of {name} lies on a cell that the oracle rejects."
    main = max(reasons, key=lambda reason: reasons[reason])
    share = "all" if reasons[main] == number else f"{reasons[main]:,}"
    because = f"because {WHAT_FAILS[main]}"
    if number == 1:
        return f"One of the {total:,} picks of {name} ({percent(number / total)}) is infeasible, {because}."
    rate = f"{percent(number / total)}{_one_in(total / number)}"
    return (
        f"{number:,} of the {total:,} picks of {name} ({rate}) lie on cells that the oracle rejects, {share} of these "
        f"{because}."
    )


def _one_in(odds: float) -> str:
    """Small shares as a count of steps."""
    return f", one in {odds:.0f}" if odds >= 3 else ""
