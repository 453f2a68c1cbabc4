"""benchmark_table.py [--quick] BUILD DATA OUTPUT: maps the recordings and prints the tables."""
import bz2
import json
import os
import subprocess
import sys

RECORDINGS = ["intel", "fr079", "mit-csail"]
# The same recording, inserted after other distances: one lucky run is no result.
INSERT_DISTANCES_M = [0.16, 0.18, 0.22, 0.24]
MATCHERS = ["hybrid", "gauss_newton", "correlative", "icp"]
MATCHER_SCANS = 1000


def run(build, log, output, *options):
    """Maps one recording and returns its statistics."""
    subprocess.run([f"{build}/map_recording", log, "--output", output, "--quiet", *options],
                   check=True)
    with open(f"{output}/stats.json") as file:
        return json.load(file)


def relations(build, data, name, output):
    """The errors of the relations whose scans were mapped; None where there is no reference."""
    path = f"{data}/{name}.relations"
    if not os.path.exists(path):
        return None
    subprocess.run([f"{build}/evaluate_trajectory", f"{output}/trajectory.tum", "--relations", path,
                    "--json", f"{output}/relations.json"], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    with open(f"{output}/relations.json") as file:
        return json.load(file)["relations"]["all"]


def mean_of(errors):
    return errors["translation_m"]["mean"] if errors else float("nan")


def row(cells):
    print("| " + " | ".join(cells) + " |", flush=True)


def header(cells):
    row(cells)
    print("|" + "---|" * len(cells), flush=True)


def accuracy_table(build, data, output, quick):
    print("\n== accuracy: every scan, one set of parameters, no loop closing", flush=True)
    header(["recording", "prediction", "lost", "error, m (mean ± std, max)", "error, deg",
            "worst of 5 runs, m", "ms a scan, mean / p99", "median ms, first / last quarter",
            "peak MB"])
    for name in RECORDINGS:
        log = f"{data}/{name}.clf.bz2"
        for odometry in ["none", "use"]:
            where = f"{output}/{name}_{odometry}"
            stats = run(build, log, where, "--odometry", odometry)
            errors = relations(build, data, name, where)
            lost = stats["scans"]["lost"]
            worst = mean_of(errors)
            for distance in [] if quick else INSERT_DISTANCES_M:
                again = f"{output}/perturbed"
                perturbed = run(build, log, again, "--odometry", odometry, "--set",
                                f"map_update_distance_thresh={distance}")
                lost += perturbed["scans"]["lost"]
                worst = max(worst, mean_of(relations(build, data, name, again)))
            cells = [name, "laser only" if odometry == "none" else "odometry", str(lost)]
            if errors:
                t, r = errors["translation_m"], errors["rotation_deg"]
                cells += [f"{t['mean']:.4f} ± {t['std']:.4f}, {t['max']:.2f}",
                          f"{r['mean']:.3f} ± {r['std']:.3f}", f"{worst:.4f}"]
            else:
                cells += ["no reference", "", ""]
            ms = stats["timing"]["ms_per_scan"]
            cells += [f"{ms['mean']:.2f} / {ms['p99']:.2f}",
                      f"{ms['median_first_quarter']:.2f} / {ms['median_last_quarter']:.2f}",
                      f"{stats['timing']['peak_memory_mb']:.0f}"]
            row(cells)


def first_scans(log, path, count):
    """Writes the head of a log, with `count` scans."""
    with bz2.open(log, "rt") as source, open(path, "w") as target:
        scans = 0
        for line in source:
            scans += line.startswith("FLASER")
            if scans > count:
                break
            target.write(line)


def matcher_table(build, data, output):
    print(f"\n== matchers: the first {MATCHER_SCANS} scans, laser only", flush=True)
    header(["matcher", "recording", "lost", "error, m (mean)", "ms a scan, mean / p99"])
    for name in ["intel", "fr079"]:
        log = f"{output}/{name}_head.clf"
        first_scans(f"{data}/{name}.clf.bz2", log, MATCHER_SCANS)
        for matcher in MATCHERS:
            where = f"{output}/{name}_{matcher}"
            stats = run(build, log, where, "--set", f"matcher={matcher}")
            ms = stats["timing"]["ms_per_scan"]
            row([matcher, name, str(stats["scans"]["lost"]),
                 f"{mean_of(relations(build, data, name, where)):.4f}",
                 f"{ms['mean']:.2f} / {ms['p99']:.2f}"])


def main():
    arguments = sys.argv[1:]
    quick = "--quick" in arguments
    build, data, output = [a for a in arguments if a != "--quick"]
    accuracy_table(build, data, output, quick)
    if not quick:
        matcher_table(build, data, output)


if __name__ == "__main__":
    main()
