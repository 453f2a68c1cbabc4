# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_table.py [--quick] BUILD DATA OUTPUT: maps the recordings and prints the tables."""
import bz2
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

RECORDINGS = ["intel", "fr079", "mit-csail"]
# A single run is not representative, so each recording is also mapped with ten small variations:
# the insertion distance (default 0.25 m) by 10 and 20 %, the first scan, missing scans or beams.
PERTURBATIONS = {
    "insert after 0.2 m": ["--set", "map_update_distance_thresh=0.2"],
    "insert after 0.225 m": ["--set", "map_update_distance_thresh=0.225"],
    "insert after 0.275 m": ["--set", "map_update_distance_thresh=0.275"],
    "insert after 0.3 m": ["--set", "map_update_distance_thresh=0.3"],
    "first 5 scans skipped": ["--skip-scans", "5"],
    "first 20 scans skipped": ["--skip-scans", "20"],
    "first 100 scans skipped": ["--skip-scans", "100"],
    "every 7th scan dropped": ["--drop-every", "7"],
    "10 % of the beams dropped": ["--drop-beams", "0.1"],
    "10 % of the beams dropped, other seed": ["--drop-beams", "0.1", "--drop-beams-seed", "2"],
}
# A trajectory with a larger error counts as lost, even if the mapper reports no lost scan.
BROKEN_M = 1.0
MATCHER_SCANS = 1000


def load(path):
    with open(path) as file:
        return json.load(file)


def run(build, log, output, *options):
    """Maps one recording and returns its statistics."""
    subprocess.run([f"{build}/map_recording", log, "--output", output, "--quiet", *options],
                   check=True, stderr=subprocess.DEVNULL)
    return load(f"{output}/stats.json")


def evaluate(build, output, *options):
    path = f"{output}/errors.json"
    subprocess.run([f"{build}/evaluate_trajectory", f"{output}/trajectory.tum", *options, "--json",
                    path], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return load(path)


def relations(build, data, name, output):
    """The errors of the relations whose scans were mapped; None if there is no relations file."""
    path = f"{data}/{name}.relations"
    if not os.path.exists(path):
        return None
    return evaluate(build, output, "--relations", path)["relations"]["all"]


def mean_of(errors):
    return errors["translation_m"]["mean"] if errors else float("nan")


def row(cells):
    print("| " + " | ".join(cells) + " |", flush=True)


def header(cells):
    row(cells)
    print("|" + "---|" * len(cells), flush=True)


def perturbed(build, data, output, name, odometry, nominal):
    """The ten runs of one recording: the mean error of each, and whether it got lost.

    Without relations the error is the distance from the unperturbed trajectory `nominal`.
    """
    def one(item):
        number, options = item
        where = f"{output}/{name}_{odometry}_{number}"
        stats = run(build, f"{data}/{name}.clf.bz2", where, "--odometry", odometry, *options)
        errors = relations(build, data, name, where)
        if not errors:
            errors = evaluate(build, where, "--reference", nominal)["reference"]["ate"]
        broken = errors["translation_m"]["max"] > BROKEN_M
        return mean_of(errors), stats["scans"]["lost"] > 0 or broken

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(one, enumerate(PERTURBATIONS.values())))


def accuracy_row(name, odometry, stats, errors, runs):
    cells = [name, "laser only" if odometry == "none" else "odometry", str(stats["scans"]["lost"])]
    if errors:
        t, r = errors["translation_m"], errors["rotation_deg"]
        cells += [f"{t['mean']:.4f} ± {t['std']:.4f}, {t['max']:.2f}",
                  f"{r['mean']:.3f} ± {r['std']:.3f}"]
    else:
        cells += ["no reference", ""]
    cells.append(f"{max(mean for mean, _ in runs):.4f}" if runs and errors else "")
    cells.append(f"{sum(lost for _, lost in runs)} of {len(runs)}" if runs else "")
    ms = stats["timing"]["ms_per_scan"]
    cells += [f"{ms['mean']:.2f} / {ms['p99']:.2f}",
              f"{ms['median_first_quarter']:.2f} / {ms['median_last_quarter']:.2f}",
              f"{stats['timing']['peak_memory_mb']:.0f}"]
    row(cells)


def perturbation_table(columns):
    print("\n== perturbed runs: mean error, m (mit-csail: mean distance from the unperturbed run)",
          flush=True)
    header(["run", *columns])
    for number, perturbation in enumerate(PERTURBATIONS):
        row([perturbation, *(f"{runs[number][0]:.4f}" + (" (lost)" if runs[number][1] else "")
                             for runs in columns.values())])


def accuracy_table(build, data, output, quick):
    print("\n== accuracy: all scans, default parameters, loops are closed", flush=True)
    header(["recording", "prediction", "scans lost", "error, m (mean ± std, max)", "error, deg",
            "worst of 10 runs, m", "lost of 10 runs", "ms per scan, mean / p99",
            "median ms, first / last quarter", "peak MB"])
    columns = {}
    for name in RECORDINGS:
        for odometry in ["none", "use"]:
            where = f"{output}/{name}_{odometry}"
            stats = run(build, f"{data}/{name}.clf.bz2", where, "--odometry", odometry)
            errors = relations(build, data, name, where)
            runs = []
            if not quick and (errors or odometry == "none"):
                runs = perturbed(build, data, output, name, odometry, f"{where}/trajectory.tum")
                columns[name + (", odometry" if odometry == "use" else "")] = runs
            accuracy_row(name, odometry, stats, errors, runs)
    if not quick:
        perturbation_table(columns)


def matcher_tables(build, data, output):
    for name in ["intel", "fr079"]:
        print(f"\n== matchers: the first {MATCHER_SCANS} scans of {name}, laser only", flush=True)
        subprocess.run([f"{build}/compare_matchers", f"{data}/{name}.clf.bz2", "--relations",
                        f"{data}/{name}.relations", "--scans", str(MATCHER_SCANS), "--quiet",
                        "--output", f"{output}/matchers_{name}"], check=True)


def main():
    arguments = sys.argv[1:]
    quick = "--quick" in arguments
    build, data, output = [a for a in arguments if a != "--quick"]
    accuracy_table(build, data, output, quick)
    if not quick:
        matcher_tables(build, data, output)


if __name__ == "__main__":
    main()
