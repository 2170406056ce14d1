#!/usr/bin/env python3
"""Draws error against run time from a result folder: a starting point for figures of your own.

    reports/replot.py FOLDER [SCENE] [-o FIGURE.pdf] [--solver GLOB]... [--norm attitude|rate|energy|momentum]

Needs python3-pandas and python3-matplotlib; polhode itself needs neither. Every column of every table is described
in FOLDER/datapackage.json; failed runs keep their rows, with an outcome that is not `ok` and no numbers.
"""
import argparse
import fnmatch
import pathlib

import matplotlib
import pandas

COLUMNS = {"attitude": ("attitude_error_max_rad", "largest attitude error / rad"),
           "rate": ("rate_error_max_rel", "largest rate error, relative"),
           "energy": ("energy_error_max_rel", "largest energy error, relative"),
           "momentum": ("momentum_error_max_rel", "largest momentum error, relative")}


def read(folder, scene, patterns):
    """Good runs of one scene, and who the solvers are."""
    runs = pandas.read_csv(folder / "work_precision.csv")
    solvers = pandas.read_csv(folder / "solvers.csv", index_col="solver")
    scene = scene or runs["scene"].iloc[0]
    runs = runs[(runs["scene"] == scene) & (runs["outcome"] == "ok")]
    if patterns:
        runs = runs[[any(fnmatch.fnmatch(solver, p) for p in patterns) for solver in runs["solver"]]]
    return scene, runs, solvers


def draw(folder, scene, patterns, norm, output):
    column, label = COLUMNS[norm]
    scene, runs, solvers = read(folder, scene, patterns)
    runs = runs[runs[column] > 0]
    if runs.empty:
        raise SystemExit(f"{folder}: no good runs of '{scene}' with an error in {norm}")
    if not output:
        output = f"{scene}-{norm}.pdf"
    matplotlib.use("agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(17.4 / 2.54, 10 / 2.54), layout="constrained")
    # One colour a family, one mark a member: the families follow the order of the registry.
    families = [family for family in dict.fromkeys(solvers["family"]) if family in
                set(solvers["family"].reindex(runs["solver"].unique()))]
    colours = pyplot.get_cmap("tab20")(range(len(families)))
    for solver, ladder in runs.groupby("solver", sort=False):
        members = [s for s in solvers.index if solvers["family"][s] == solvers["family"][solver]]
        axes.errorbar(ladder[column], ladder["time_min_s"], yerr=ladder["time_mad_s"], label=solver, linewidth=1,
                      marker="osv^D<>p"[members.index(solver) % 8], markersize=3,
                      color=colours[families.index(solvers["family"][solver])])
    axes.set(xscale="log", yscale="log", xlabel=label, ylabel="run time / s", title=scene)
    axes.grid(color="#e4e4e4", linewidth=0.6)
    axes.legend(fontsize=6, loc="upper left", bbox_to_anchor=(1, 1), frameon=False, ncols=1 + len(runs["solver"].unique()) // 30)
    figure.savefig(output)
    print(output)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("scene", nargs="?")
    parser.add_argument("-o", "--output")
    parser.add_argument("--solver", action="append", default=[], help="id or glob, may be repeated")
    parser.add_argument("--norm", choices=COLUMNS, default="attitude")
    arguments = parser.parse_args()
    draw(arguments.folder, arguments.scene, arguments.solver, arguments.norm, arguments.output)
