"""The terrain cost c_m: `footsel terrain-cost fit` makes its numbers from simulated slippage."""

import argparse

from footsel.cli.numbers import whole_number
from footsel.cli.options import add_jobs, add_robot, add_seed, needing, output_folder
from footsel.files import write_json

HELP = "slip trials and the fit of the terrain cost"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel terrain-cost`."""
    actions = parser.add_subparsers(metavar="ACTION", required=True, title="actions")
    fit = actions.add_parser(
        "fit",
        help="set feet down on courses of every family, push them, and fit the cost to how far they slip",
        description="Slip trials in PyBullet: a foot is set on random cells of terrain courses, loaded and pushed; "
        "a mixture of Gaussians is fitted to how far it slips. Killed and started again, it goes on.",
        allow_abbrev=False,
    )
    fit.add_argument("out", metavar="OUT", type=output_folder, help="folder of the trials, the fit and its figures")
    # Its own help is where to read on.
    fit.set_defaults(command_parser=fit)
    fit.add_argument(
        "--placements",
        type=whole_number(1),
        default=24000,
        metavar="N",
        help="placements of a foot to fit (default: %(default)s)",
    )
    fit.add_argument(
        "--held-out",
        type=whole_number(1),
        default=4800,
        metavar="N",
        help="placements on other courses, to judge the fit by (default: %(default)s)",
    )
    add_robot(fit)
    add_seed(fit)
    add_jobs(fit)


def run(args: argparse.Namespace) -> int:
    """Run the trials, fit, write OUT/terrain_cost.json and say how well it does."""
    with needing("footsel terrain-cost", "sim"):
        import footsel.walking.bullet  # noqa: F401
        from footsel.oracle.terrain_cost import DATA_FILE
        from footsel.robot import load_robot
        from footsel.walking.slip.campaign import CampaignConfig, run_campaign
        from footsel.walking.slip.fit import data_file, fit_model, report
        from footsel.walking.slip.landmarks import measure

    config = CampaignConfig(args.robot, args.placements, args.held_out, args.seed)
    trials = run_campaign(config, args.out, args.jobs)
    model = fit_model(trials.take(~trials.held_out))
    figures = report(model, trials)
    figures["landmarks"] = measure(model, load_robot(config.robot).description.foot_radius)
    path = args.out / DATA_FILE
    write_json(path, data_file(model, config, figures))
    held_out = figures["held_out"]
    print(
        f"{path}: {len(trials)} placements; on courses not fitted, Spearman's correlation of cost and slip is "
        f"{held_out['spearman_worst_quarter']}, explained variance {held_out['explained_variance']}"
    )
    print(f"next: copy it to footsel/oracle/{DATA_FILE}; labels, data sets and networks made before do not know it")
    return 0
