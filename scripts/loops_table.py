# SPDX-License-Identifier: BSD-3-Clause
"""Prints the tables of scripts/benchmark_loops."""
import argparse
import os
import subprocess

import benchmark_table as table

LOGS = ["acapulco", "fhw", "freiburg-101", "belgioioso", "orebro", "freiburg-campus"]
FLIGHTS = ["corridor ring, 5 cm", "corridor ring, 10 cm", "laboratory loop, 5 cm", "spin at 2 rad/s"]
SEEDS = 5


def loops_of(stats):
    """Number of accepted loops, of other ones, and the largest correction."""
    if stats["graph"] == "none":
        return ["", "", ""]
    counts = stats["graph"]["loops"]
    accepted = counts.get("accepted", 0)
    return [str(accepted), str(sum(counts.values()) - accepted),
            f"{stats['graph']['largest_correction_m']:.2f}"]


def time_ratio(with_loops, without):
    return f"{with_loops['timing']['processing_s'] / without['timing']['processing_s']:.2f}"


def relations_table(args):
    print("\n== laser only, mean error of the relations, m", flush=True)
    table.header(["recording", "loops", "mean", "max", "worst of 10 runs", "accepted", "other",
                  "largest correction, m", "time with / without loops"])
    data = f"{args.data}/freiburg"
    for name in ["intel", "fr079"]:
        before = None
        for loops in ["none", "use"]:
            output = f"{args.output}/{name}_{loops}"
            log = f"{data}/{name}.clf.bz2"
            stats = table.run(args.build, log, output, "--loops", loops)
            errors = table.relations(args.build, data, name, output)
            worst = "" if args.quick else f"{worst_run(args, name, loops):.4f}"
            ratio = "" if before is None else time_ratio(stats, before)
            table.row([name, loops, f"{table.mean_of(errors):.4f}",
                       f"{errors['translation_m']['max']:.2f}", worst, *loops_of(stats), ratio])
            before = stats


def worst_run(args, name, loops):
    data, worst = f"{args.data}/freiburg", 0.0
    for number, options in enumerate(table.PERTURBATIONS.values()):
        output = f"{args.output}/{name}_{loops}_{number}"
        table.run(args.build, f"{data}/{name}.clf.bz2", output, "--loops", loops, *options)
        worst = max(worst, table.mean_of(table.relations(args.build, data, name, output)))
    return worst


def reference_table(args):
    print("\n== with odometry, absolute error to the reference, m", flush=True)
    table.header(["recording", "loops", "rmse", "max", "lost", "accepted", "other",
                  "largest correction, m"])
    for name in LOGS:
        for loops in ["none", "use"]:
            output = f"{args.output}/{name}_{loops}"
            log = f"{args.data}/radish/{name}.clf.gz"
            stats = table.run(args.build, log, output, "--odometry", "use", "--loops", loops)
            errors = table.evaluate(args.build, output, "--reference",
                                    f"{args.data}/radish/{name}.reference.tum")["reference"]["ate"]
            error = errors["translation_m"]
            table.row([name, loops, f"{error['rmse']:.2f}", f"{error['max']:.2f}",
                       str(stats["scans"]["lost"]), *loops_of(stats)])


def flight_table(args):
    print(f"\n== simulated flights, {SEEDS} seeds", flush=True)
    for flight in FLIGHTS:
        for loops in ["false", "true"]:
            lines = subprocess.run(
                [f"{args.build}/measure_seeds", "--only", flight, "--seeds", str(SEEDS), "--set",
                 f"graph={loops}"], check=True, capture_output=True, text=True).stdout.splitlines()
            if flight == FLIGHTS[0] and loops == "false":
                print("| graph " + "\n|---".join(lines[-3:-1]), flush=True)
            print(f"| {loops} {lines[-1]}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    for name in ["build", "data", "output"]:
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--quick", action="store_true")
    args = parser.parse_args()
    args.build = os.path.abspath(args.build)
    os.makedirs(args.output, exist_ok=True)
    relations_table(args)
    reference_table(args)
    if not args.quick:
        flight_table(args)


if __name__ == "__main__":
    main()
