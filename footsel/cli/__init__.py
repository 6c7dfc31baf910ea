"""The command line: one module per subcommand, each with HELP, `add_arguments(parser)` and `run(args) -> exit code`.

Modules are imported to show help, so packages beyond the standard library are imported inside `run`.
"""
