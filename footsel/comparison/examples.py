"""Which legs the report shows in pictures: what went wrong, and something typical of every map."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from footsel.comparison.compare import Comparison
from footsel.comparison.judge import Outcome
from footsel.comparison.maps import NamedMap
from footsel.legs import LEGS

#: Typical legs are shown of at most this many maps, spread over all of them.
MOST_TYPICAL = 11
#: A typical local map is known at least to this share.
MOSTLY_KNOWN = 0.9


@dataclass(frozen=True, eq=False)
class Example:
    """One leg at one base pose. why: the reason to show it, as a heading."""

    why: str
    map: NamedMap
    outcome: Outcome


def choose_examples(comparison: Comparison) -> list[Example]:
    """Three ways in which the judged selector can be wrong, as far as they happened, then a typical leg per map."""
    name = judged_selector(comparison)
    every = [
        (named, outcome)
        for named, verdict in zip(comparison.maps, comparison.verdicts, strict=True)
        for outcome in verdict.outcomes
    ]
    examples: list[Example] = []

    def add_most(why: str, among: Callable[[Outcome], bool], measure: Callable[[Outcome], float]) -> None:
        found = [(named, outcome) for named, outcome in every if among(outcome)]
        if found:
            examples.append(Example(why, *max(found, key=lambda pair: measure(pair[1]))))

    if name is not None:
        regret = _regrets_of(name)
        add_most(
            f"A pick of {name} that the oracle rejects",
            lambda o: regret(o) == np.inf,
            lambda o: o.known + o.feasible,
        )
        add_most(f"The largest regret of {name}", lambda o: 0 < regret(o) < np.inf, regret)
        add_most(
            f"A leg with footholds for which {name} found none",
            lambda o: o.regrets[name] is None and o.feasible > 0,
            lambda o: o.feasible,
        )
    return examples + list(_typical(comparison, name))


def judged_selector(comparison: Comparison) -> str | None:
    """The selector that the report is about: the network, else the first that is not the oracle, if any."""
    names = list(comparison.contestants.selectors)
    if "cnn" in names:
        return "cnn"
    return next((name for name in names if name != "oracle"), None)


def _typical(comparison: Comparison, name: str | None) -> Iterator[Example]:
    """Of each map, the leg of median regret among those on known ground; legs take turns."""
    regret = _regrets_of(name)
    count = len(comparison.maps)
    shown = np.unique(np.linspace(0, count - 1, min(count, MOST_TYPICAL)).round().astype(int)).tolist()
    for turn, index in enumerate(shown):
        outcomes = comparison.verdicts[index].outcomes
        leg = LEGS[turn % len(LEGS)]
        for candidates in (
            [o for o in outcomes if o.leg == leg and o.known >= MOSTLY_KNOWN and regret(o) < np.inf],
            [o for o in outcomes if o.feasible > 0],
            outcomes,
        ):
            if candidates:
                ranked = sorted(candidates, key=regret)
                named = comparison.maps[index]
                yield Example("Typical", named, ranked[len(ranked) // 2])
                break


def _regrets_of(name: str | None) -> Callable[[Outcome], float]:
    """Outcome -> regret of a selector, -1 if it chose nothing; 0 if there is no such selector."""

    def regret(outcome: Outcome) -> float:
        value = outcome.regrets[name] if name is not None else 0.0
        return -1.0 if value is None else value

    return regret
