#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""summarize_tests.py LABEL RESULTS BUILD: counts the test cases of one run of ctest.

RESULTS holds ctest.junit and the XML files of GoogleTest, BUILD/test_results those of rostest.
Prints one line for each suite, `LABEL: NAME  N passed, N failed, N skipped`. The output of failed
tests comes before this line, the reasons of skipped tests after it. A suite that failed in ctest
counts at least one failure, even if it crashed before it wrote its results.
"""

import os
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

CATKIN_PREFIX = "_ctest_kestrel_slam_"
LONGEST_OUTPUT = 6000  # number of characters that are shown of the output of a failed suite


def count_cases(path, reasons):
    """Returns [passed, failed, skipped] of a result file; adds skip reasons to `reasons`."""
    counts = [0, 0, 0]
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        tags = {child.tag for child in case}
        if tags & {"failure", "error"}:
            counts[1] += 1
        elif "skipped" in tags or case.get("status") == "notrun":
            skipped = case.find("skipped")
            text = "" if skipped is None else skipped.get("message") or skipped.text or ""
            lines = text.strip().splitlines() or ["no reason given"]
            # GoogleTest gives no reason, only the place, where the set-up of the suite has failed.
            failed = len(lines) == 1 and re.fullmatch(r"\S+:\d+", lines[0]) is not None
            counts[1 if failed else 2] += 1
            if not failed:
                reasons.add(lines[-1])
        else:
            counts[0] += 1
    return counts


def result_files(name, results, build):
    """The result files of the ctest test `name`, which is a GoogleTest program or a rostest."""
    if not name.startswith(CATKIN_PREFIX):
        return list(results.glob(f"test_{name}.xml"))
    stem = name[len(CATKIN_PREFIX):].replace("rostest_", "rostest-", 1)
    stem = stem[:-len(".test")] if stem.endswith(".test") else stem
    outer = list((build / "test_results" / "kestrel_slam").glob(f"{stem}.xml"))
    # The file of a rostest only gives the paths of the result files of its programs.
    inner = [pathlib.Path(path) for file in outer
             for path in re.findall(r"results are in \[(.*?)\]", file.read_text())]
    return [path for path in inner if path.exists()] or outer


def program_outputs(files):
    """What the programs of a rostest wrote. Their result files do not say why a set-up failed."""
    texts = []
    for file in files:
        name = file.stem.replace("rosunit-", "", 1)
        logs = list(pathlib.Path(os.environ.get("ROS_LOG_DIR", "")).glob(f"*/{name}-*stdout.log"))
        if logs:
            newest = max(logs, key=lambda log: log.stat().st_mtime)
            texts.append(f"{newest}:\n{newest.read_text(errors='replace')[-LONGEST_OUTPUT:]}")
    return texts


def count_suite(case, results, build, reasons):
    """Returns [passed, failed, skipped] of one ctest test."""
    failed = case.get("status") == "fail"
    totals = [0, 0, 0]
    for path in result_files(case.get("name"), results, build):
        try:
            totals = [a + b for a, b in zip(totals, count_cases(path, reasons))]
        except ElementTree.ParseError:
            failed = True  # the file is incomplete after a crash
    if failed and totals[1] == 0:
        totals[1] = 1
    if sum(totals) == 0:
        totals[2 if case.get("status") in ("disabled", "notrun") else 0] = 1
    return totals


def main():
    label, results, build = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    report = results / "ctest.junit"
    if not report.exists():
        print(f"{label + ': ctest did not run':<44}    0 passed, 1 failed, 0 skipped")
        return
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        reasons = set()
        counts = count_suite(case, results, build, reasons)
        if counts[1] > 0:
            print((case.findtext("system-out") or "")[-LONGEST_OUTPUT:])
            if case.get("name").startswith(CATKIN_PREFIX):
                print(*program_outputs(result_files(case.get("name"), results, build)), sep="\n")
        name = case.get("name").replace(CATKIN_PREFIX, "")
        print(f"{label + ': ' + name:<44} {counts[0]:4d} passed, {counts[1]} failed, "
              f"{counts[2]} skipped")
        for reason in sorted(reasons):
            print(f"    skipped: {reason}")


main()
