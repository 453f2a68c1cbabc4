# SPDX-License-Identifier: BSD-3-Clause
"""sessions_table.py --build DIR --data DIR --output DIR [--only TEXT] [--quick]: finds vehicles in
maps of which they know nothing, localizes in them, and saves and loads sessions. Prints a table of
goals and values. scripts/benchmark_sessions calls it."""
import re
import subprocess
import sys

import goal_table
from goal_table import row

RECORDINGS = ["fr079", "mit-csail", "intel"]
RADISH = ["acapulco", "belgioioso", "fhw", "freiburg-101", "orebro", "freiburg-campus"]
NOTHING = ["--search", "0", "--localize", "0", "--kidnappings", "0"]


class Benchmark:
    def __init__(self, arguments):
        self.build, self.data = arguments.build, arguments.data

    def log(self, name):
        return f"{self.data}/freiburg/{name}.clf.bz2"

    def run(self, tool, *options):
        """What a tool prints."""
        print(tool, *options[:4], file=sys.stderr, flush=True)
        return subprocess.run([f"{self.build}/{tool}", *map(str, options)], check=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout

    def relocalize(self, *options):
        return self.run("measure_relocalization", *options)


def rows_of(text):
    return [line.strip("| \n").split(" | ") for line in text.splitlines() if line.startswith("|")]


def search_row(cells, goal):
    """A row of the searches in one map."""
    name, _, query, queries, inside, right, ambiguous, unknown, wrong, p50, p99 = cells[:11]
    is_quick = float(p50) <= 0.3 and float(p99) <= 1.0
    row(f"{name}, {query}", f"right ≥ {goal} %, wrong 0; p50 ≤ 0.3 s, p99 ≤ 1 s",
        f"{right} % of {inside} in the map (of {queries}); ambiguous {ambiguous}, unknown "
        f"{unknown}; wrong {wrong}; {p50} s, {p99} s; {cells[13]} MB above the map",
        float(right) >= goal and wrong == "0" and is_quick)


def unknown_pose(bench):
    for name in RECORDINGS:
        text = bench.relocalize(bench.log(name), "--localize", 0, "--kidnappings", 0)
        for cells in rows_of(text)[2:]:
            search_row(cells, 90 if cells[2] == "single scan" else 99)


def other_buildings(bench):
    logs = [bench.log(name) for name in RECORDINGS]
    logs += [f"{bench.data}/radish/{name}.clf.gz" for name in RADISH]
    text = bench.relocalize(*logs, *NOTHING, "--strangers", 17)
    searches = [cells for cells in rows_of(text) if len(cells) > 8 and cells[3].isdigit()]
    wrong = sum(int(cells[8]) for cells in searches)
    row(f"scans of other buildings, {len(logs)} maps", "none accepted",
        f"{wrong} of {sum(int(cells[3]) for cells in searches)}", wrong == 0)


def localization(bench):
    text = bench.relocalize(bench.log("intel"), "--search", 0, "--kidnappings", 0)
    for line in re.findall(r"^intel: second half in the .*$", text, re.MULTILINE):
        scans, lost, wrong = re.search(r"(\d+) scans, (\d+) lost, (\d+) wrong", line).groups()
        mean = re.search(r"relations across: ([\d.]+) m", line)
        row("intel, " + line[len("intel: "):line.index(" of the first")] + " of the first",
            "wrong 0; relations across ≤ 0.0146 m",
            f"{wrong} wrong, {lost} without a pose of {scans}; "
            + (f"relations {mean[1]} m" if mean else "no relations"),
            wrong == "0" and mean is not None and float(mean[1]) <= 0.0146)


def carried_row(text):
    pattern = r"^(.*): noticed within 1 s (\d+) of (\d+), found within 3 m (\d+), .* 1 s (\d+)$"
    for name, noticed, all_, found, wrong in re.findall(pattern, text, re.MULTILINE):
        row(name, "noticed and found in all, wrong 0",
            f"noticed {noticed}, found {found} of {all_}; at a wrong place {wrong}",
            noticed == found == all_ and wrong == "0")


def kidnapped(bench):
    only = ["--search", "0", "--localize", "0"]
    carried_row(bench.relocalize(bench.log("fr079"), "--kidnappings", 100, *only))
    carried_row(bench.relocalize("--world", "office", *only))
    carried_row(bench.relocalize("--world", "twins", "--kidnappings", 20, *only))


def gaps(bench):
    for name in RECORDINGS:
        text = bench.relocalize(bench.log(name), *NOTHING, "--gaps", 60)
        scans, lost, wrong = re.search(r"of (\d+) scans after them (\d+) lost, (\d+) wrong",
                                       text).groups()
        row(f"{name}, 60 gaps of 0.2 to 4 s", "wrong and not said to be lost 0",
            f"{wrong} wrong, {lost} lost of {scans} scans", wrong == "0")


def saved(bench):
    text = bench.run("measure_sessions", bench.log("intel"), "--flights", 2, "--kills", 200)
    first, second = rows_of(text)[2:4]
    megabytes, written, loaded = (float(cell.split()[0]) for cell in (first[4], first[6], first[7]))
    row("session of intel", "≤ 15 MB; saved ≤ 0.5 s; loaded ≤ 2 s",
        f"{first[4]}; {first[6]}; {first[7]}",
        megabytes <= 15.0 and written <= 0.5 and loaded <= 2.0)
    row("intel flown again", "joined; the map grows by ≤ 10 %", f"joined: {second[3]}; {second[2]}",
        second[3] == "yes" and float(second[2].split()[0]) <= 10.0)
    problems = re.search(r"killed (\d+) times while saving: (\d+) problems", text).groups()
    different = re.search(r"damaged (\d+) times: .* (\d+) SILENTLY", text).groups()
    row(f"killed {problems[0]} times while saving", "every file is whole", f"{problems[1]} problems",
        problems[1] == "0")
    row(f"{different[0]} damaged files", "refused, or the same content",
        f"{different[1]} silently different", different[1] == "0")


def days(bench):
    text = bench.run("measure_sessions", bench.log("fr079"), "--kills", 0, "--flips", 0)
    flights = rows_of(text)[2:]
    growth = max(float(cells[2].split()[0]) for cells in flights[1:])
    drift = max(float(cells[5].split()[0]) for cells in flights)
    joined = all(cells[3] == "yes" for cells in flights)
    row(f"fr079 flown {len(flights)} times", "all joined; growth ≤ 10 % each",
        f"{'all joined' if joined else 'NOT ALL JOINED'}; growth at most {growth:.1f} %; "
        f"drift at most {drift:.3f} m", joined and growth <= 10.0)


# name: function, whether it takes long
GROUPS = {
    "unknown pose": (unknown_pose, False),
    "other buildings": (other_buildings, True),
    "localization": (localization, False),
    "kidnapped": (kidnapped, True),
    "gaps": (gaps, False),
    "saved sessions": (saved, False),
    "days": (days, True),
}


if __name__ == "__main__":
    goal_table.run(__doc__, GROUPS, Benchmark)
