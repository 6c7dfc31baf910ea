"""Numbers on the command line: every spelling of a float, negative ones too, and checks that say what is wrong."""

import math
from collections.abc import Callable, Sequence

from footsel.errors import InputError


def protect_negative_numbers(argv: Sequence[str]) -> list[str]:
    """`argv` with a space before each negative number.

    argparse takes `-1e-05` and `-inf` for options. What begins with a space is a value to it, and float() and int() do
    not mind the space.
    """
    return [f" {word}" if word.startswith("-") and _is_float(word) else word for word in argv]


def finite_number(text: str) -> float:
    """A finite float; raises InputError for anything else."""
    if not _is_float(text) or not math.isfinite(float(text)):
        raise InputError(f"{text.strip()!r} is no finite number", "give a number such as 0.5 or -1e-05")
    return float(text)


def positive_number(text: str) -> float:
    """A finite float above 0; raises InputError for anything else."""
    number = finite_number(text)
    if number <= 0:
        raise InputError(f"{text.strip()!r} is no number above 0", "give a number such as 0.001")
    return number


def share(text: str) -> float:
    """A number from 0 to less than 1; raises InputError for anything else."""
    number = finite_number(text)
    if not 0 <= number < 1:
        raise InputError(f"{text.strip()!r} is no share", "give 0 or more and less than 1, such as 0.2")
    return number


def whole_number(least: int) -> Callable[[str], int]:
    """A parser of whole numbers of `least` or more."""

    def parse(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if number < least:
            raise InputError(f"{text.strip()!r} is no whole number of {least} or more", f"give {least} or more")
        return number

    return parse


def jobs(text: str) -> int:
    """A number of processes; -1 is one per core. Raises InputError for anything else."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number != -1 and number < 1:
        raise InputError(f"{text.strip()!r} is no number of jobs", "give a count of 1 or more, or -1 for all cores")
    return number


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
