# SPDX-License-Identifier: BSD-3-Clause
"""Recordings thinned to a scan per meter, or per half a radian. robustness_table.py uses them."""
import bz2
import math
import os

STEP_M, STEP_RAD = 1.0, 0.5
STARTS = [0, 1, 3, 5, 9]  # mapped from these scans on


def write_thinned(log, path):
    """Writes the scans of a log in the format of CARMEN that are far enough apart."""
    last = None
    with bz2.open(log, "rt") as lines, open(path, "w") as file:
        for line in lines:
            words = line.split()
            if not words or words[0] != "FLASER":
                continue
            first = 2 + int(words[1])  # after the ranges: the pose of the laser by the odometry
            x, y, yaw = (float(word) for word in words[first:first + 3])
            if last:
                turn = abs(math.remainder(yaw - last[2], 2.0 * math.pi))
                if math.dist((x, y), last[:2]) < STEP_M and turn < STEP_RAD:
                    continue
            last = (x, y, yaw)
            file.write(line)


class ThinnedRecording:
    """A recording as a thinned log. The reference is the trajectory with all scans."""

    def __init__(self, bench, log):
        whole = f"freiburg/{log}.clf.bz2"
        folder = os.path.abspath(bench.map(whole, f"{log}_whole"))
        self.bench, self.log = bench, log
        self.reference, self.thinned = f"{folder}/trajectory.tum", f"{folder}/thinned.clf"
        write_thinned(f"{bench.data}/{whole}", self.thinned)

    def runs(self, name, *options):
        """The states with each start."""
        def from_start(start):
            folder = f"{self.log}_thinned_{name}_{start}"
            self.bench.map(self.thinned, folder, "--skip-scans", str(start), *options)
            return self.bench.states(folder, self.reference)

        return self.bench.at_once(from_start, STARTS)
