# SPDX-License-Identifier: BSD-3-Clause
"""Prints the tables of scripts/benchmark_loops."""
import argparse
import bisect
import csv
import math
import os
import resource
import statistics
import subprocess

import benchmark_table as table

LOGS = ["acapulco", "fhw", "freiburg-101", "belgioioso", "orebro", "freiburg-campus"]
FLIGHTS = ["corridor ring, 5 cm", "corridor ring, 10 cm", "laboratory loop, 5 cm", "spin at 2 rad/s"]
SEEDS = 5
# Some decimeters of a loop's difference from the reference are errors of the reference.
WRONG_LOOP_M = 1.0


class Reference:
    """Poses of a TUM file, interpolated between two stamps."""

    def __init__(self, path):
        self.stamps, self.poses = [], []
        with open(path) as file:
            for line in file:
                stamp, x, y, _, _, _, qz, qw = (float(value) for value in line.split())
                self.stamps.append(stamp)
                self.poses.append((x, y, 2 * math.atan2(qz, qw)))

    def at(self, stamp):
        """None outside of the reference."""
        if not self.stamps[0] <= stamp <= self.stamps[-1]:
            return None
        after = max(1, bisect.bisect_left(self.stamps, stamp))
        (x, y, yaw), (x1, y1, yaw1) = self.poses[after - 1], self.poses[after]
        begin, end = self.stamps[after - 1], self.stamps[after]
        share = (stamp - begin) / (end - begin)
        turn = math.remainder(yaw1 - yaw, 2 * math.pi)
        return x + share * (x1 - x), y + share * (y1 - y), yaw + share * turn

    def loop_error(self, loop):
        """Distance between the place of the query in the loop and in the reference, m."""
        anchor, query = self.at(float(loop["anchor"])), self.at(float(loop["query"]))
        if anchor is None or query is None:
            return None
        dx, dy = query[0] - anchor[0], query[1] - anchor[1]
        cos, sin = math.cos(anchor[2]), math.sin(anchor[2])
        return math.hypot(cos * dx + sin * dy - float(loop["x"]),
                          -sin * dx + cos * dy - float(loop["y"]))


def loop_errors(output, reference):
    """The errors of the accepted loops, m."""
    with open(f"{output}/loops.csv", newline="") as file:
        accepted = [loop for loop in csv.DictReader(file) if loop["state"] == "accepted"]
    errors = (reference.loop_error(loop) for loop in accepted)
    return [error for error in errors if error is not None]


def loops_of(stats):
    """Number of accepted loops, of other ones, and the largest correction."""
    if stats["graph"] == "none":
        return ["", "", ""]
    counts = stats["graph"]["loops"]
    accepted = counts.get("accepted", 0)
    return [str(accepted), str(sum(counts.values()) - accepted),
            f"{stats['graph']['largest_correction_m']:.2f}"]


def processor_time():
    """Of all programs that have ended, s. It hardly depends on what else runs."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def relations_table(args):
    print("\n== laser only, mean error of the relations, m", flush=True)
    table.header(["recording", "loops", "mean", "max", "worst of 10 runs", "accepted", "other",
                  "largest correction, m", "peak MB", "processor time, s"])
    data = f"{args.data}/freiburg"
    for name in ["intel", "fr079"]:
        for loops in ["none", "use"]:
            output = f"{args.output}/{name}_{loops}"
            log = f"{data}/{name}.clf.bz2"
            before = processor_time()
            stats = table.run(args.build, log, output, "--loops", loops)
            seconds = processor_time() - before
            errors = table.relations(args.build, data, name, output)
            worst = "" if args.quick else f"{worst_run(args, name, loops):.4f}"
            table.row([name, loops, f"{table.mean_of(errors):.4f}",
                       f"{errors['translation_m']['max']:.2f}", worst, *loops_of(stats),
                       f"{stats['timing']['peak_memory_mb']:.0f}", f"{seconds:.1f}"])


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


def perturbed_table(args):
    print(f"\n== with odometry, perturbed runs: accepted loops more than {WRONG_LOOP_M} m away from "
          "the reference", flush=True)
    table.header(["recording", "runs", "loops", "wrong", "largest error of a loop, m",
                  "rmse, median, m", "rmse, worst, m", "lost"])
    for name in LOGS:
        path = f"{args.data}/radish/{name}.reference.tum"
        reference, loops, rmses, lost = Reference(path), [], [], 0
        for number, options in enumerate([[], *table.PERTURBATIONS.values()]):
            output = f"{args.output}/{name}_perturbed_{number}"
            stats = table.run(args.build, f"{args.data}/radish/{name}.clf.gz", output,
                              "--odometry", "use", *options)
            loops += loop_errors(output, reference)
            errors = table.evaluate(args.build, output, "--reference", path)["reference"]["ate"]
            rmses.append(errors["translation_m"]["rmse"])
            lost += stats["scans"]["lost"]
        wrong = sum(error > WRONG_LOOP_M for error in loops)
        table.row([name, str(len(rmses)), str(len(loops)), str(wrong), f"{max(loops):.2f}",
                   f"{statistics.median(rmses):.2f}", f"{max(rmses):.2f}", str(lost)])


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
        perturbed_table(args)
        flight_table(args)


if __name__ == "__main__":
    main()
