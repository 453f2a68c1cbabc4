# SPDX-License-Identifier: BSD-3-Clause
"""goal_table.py: tables of goals and values. Their rows are in groups that can be chosen."""
import argparse
import os

import benchmark_table


def row(measure, goal, value, is_reached):
    benchmark_table.row([measure, goal, value, "yes" if is_reached else "**no**"])


def percent(part, whole):
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def parse(description, options):
    parser = argparse.ArgumentParser(description=description)
    for name in ["build", "data", "output"]:
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    for name, default in options.items():
        parser.add_argument(f"--{name}", type=type(default), default=default)
    return parser.parse_args()


def is_chosen(name, is_slow, arguments):
    if arguments.only:
        return any(text in name for text in arguments.only)
    return not (arguments.quick and is_slow)


def run(description, groups, benchmark, options=None):
    """Prints the rows of the chosen groups.

    groups: by name, a function that prints rows with a `benchmark`, and whether it takes long.
    """
    arguments = parse(description, options or {})
    chosen = {name: function for name, (function, is_slow) in groups.items()
              if is_chosen(name, is_slow, arguments)}
    if arguments.list:
        for name in chosen:
            print(name + (" (slow)" if groups[name][1] else ""))
        return
    arguments.build = os.path.abspath(arguments.build)
    arguments.output = os.path.abspath(arguments.output)
    os.makedirs(arguments.output, exist_ok=True)
    bench = benchmark(arguments)
    benchmark_table.header(["measure", "goal", "value", "reached"])
    for function in chosen.values():
        function(bench)
