"""Errors as a worker process hands them back."""

import importlib
import pickle
import pkgutil

import joblib
import pytest

import footsel
from footsel.dataset.engine import WorkersLostError
from footsel.errors import FootselError, InputError, MapError, MissingExtraError, ModelError, UnknownNameError

EXAMPLES = {
    FootselError: ("all is lost",),
    InputError: ("a fish", "take a map"),
    MapError: ("an empty map",),
    MissingExtraError: ("the oracle", "oracle", "coal"),
    ModelError: ("no model", "train one"),
    UnknownNameError: ("leg", "XX", iter(["LF", "RF"])),
    WorkersLostError: ("a worker was killed", "start again"),
}


@pytest.fixture(scope="module")
def every_error() -> list[type[FootselError]]:
    """All error classes of the package, wherever they are defined."""
    for module in pkgutil.walk_packages(footsel.__path__, "footsel."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    found, left = set(), [FootselError]
    while left:
        found.add(left[-1])
        left += left.pop().__subclasses__()
    return sorted(
        (error for error in found if error.__module__.startswith("footsel.")), key=lambda error: error.__name__
    )


def one_of(error: type[FootselError]) -> FootselError:
    """An example; one of a class without its own is made like its base's."""
    return error(*next(EXAMPLES[base] for base in error.__mro__ if base in EXAMPLES))


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_every_error_is_the_same_after_pickling(every_error, protocol):
    assert set(EXAMPLES) <= set(every_error)
    for error in every_error:
        sent = one_of(error)
        got = pickle.loads(pickle.dumps(sent, protocol))
        assert type(got) is error
        assert str(got) == str(sent) and got.args == sent.args and vars(got) == vars(sent)


def fail(*_: object) -> None:
    raise UnknownNameError("robot", "spot", ["anymal_b"])


def test_an_error_comes_back_from_another_process():
    with pytest.raises(UnknownNameError, match=r"^unknown robot 'spot'; choose from: anymal_b$") as caught:
        joblib.Parallel(n_jobs=2)(joblib.delayed(fail)(number) for number in range(2))
    assert caught.value.known == ("anymal_b",)


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (InputError("a fish"), "a fish"),
        (InputError("a fish", "take a map"), "a fish; take a map"),
        (
            MissingExtraError("the oracle", "oracle", "coal"),
            "the oracle needs the package 'coal'; run: pip install 'footsel[oracle]'",
        ),
    ],
)
def test_an_error_is_one_line(error, line):
    assert str(error) == line
