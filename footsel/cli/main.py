"""`footsel`: finds the subcommand, runs it, and turns everything a user can do wrong into one line and exit code 2."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NoReturn

import footsel
from footsel.cli.numbers import protect_negative_numbers
from footsel.errors import FootselError, InputError

#: In the order of their use. Each is the module `footsel.cli.NAME`, hyphens as underscores.
COMMANDS = (
    "label",
    "select",
    "dataset",
    "train",
    "evaluate",
    "export",
    "terrain-cost",
    "walk",
    "compare",
    "bench",
    "robots",
)

EXIT_MISUSE = 2
EXIT_INTERRUPTED = 130  # 128 + SIGINT
EXIT_NOBODY_READS = 141  # 128 + SIGPIPE


class Parser(argparse.ArgumentParser):
    """Raises InputError for wrong use, with the option's name, and takes no abbreviated options."""

    def error(self, message: str) -> NoReturn:
        """What argparse found wrong, and where to read on."""
        raise InputError(message, f"see `{self.prog} --help`")

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        try:
            return super()._get_value(action, arg_string)
        except InputError as error:
            name = action.option_strings[0] if action.option_strings else action.metavar
            raise InputError(f"{name}: {error.what}", error.remedy) from None


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line (default: the process's own) and return its exit code."""
    try:
        code = _run(sys.argv[1:] if argv is None else argv)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # Whoever read our output has left, as `head` does. What is still buffered must not fail again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_NOBODY_READS
    except FootselError as error:
        return _misuse(str(error))
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _misuse(f"{place}{error.strerror or error}; check that the path exists and its permissions")
    except KeyboardInterrupt:
        print("footsel: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED


def make_parser() -> Parser:
    """The parser of all commands."""
    parser = Parser(prog="footsel", description=footsel.__doc__, allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"footsel {footsel.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, title="commands")
    for name in COMMANDS:
        module = import_module(f"footsel.cli.{name.replace('-', '_')}")
        command = commands.add_parser(name, help=module.HELP, description=module.__doc__, allow_abbrev=False)
        module.add_arguments(command)
        command.set_defaults(execute=module.run, command_parser=command)
    return parser


def _run(argv: Sequence[str]) -> int:
    args, unknown = make_parser().parse_known_args(protect_negative_numbers(argv))
    if unknown:
        args.command_parser.error(f"unknown arguments: {' '.join(unknown)}")
    return int(args.execute(args))


def _misuse(message: str) -> int:
    """Say in one line what was wrong."""
    print(f"footsel: error: {' '.join(message.split())}", file=sys.stderr)
    return EXIT_MISUSE


if __name__ == "__main__":
    sys.exit(main())
