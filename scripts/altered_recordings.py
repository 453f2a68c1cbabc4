# SPDX-License-Identifier: BSD-3-Clause
"""Recordings that are thinned, played backward, or see parts of the vehicle. robustness_table.py
uses them."""
import bz2
import math
import os
import random

STEP_M, STEP_RAD = 1.0, 0.5
PARTS, PART_SHARE, PART_M = (0.15, 0.5, 0.85), 0.04, 0.25  # shares of the view; distance
STARTS = [0, 1, 3, 5, 9]  # mapped from these scans on


def laser_lines(log):
    """The scans of a log in the format of CARMEN, each as its words."""
    with bz2.open(log, "rt") as lines:
        for words in map(str.split, lines):
            if words and words[0] == "FLASER":
                yield words


def after_ranges(words):
    """The index of the pose of the laser by the odometry. The stamp comes six words later."""
    return 2 + int(words[1])


def write_lines(path, lines):
    with open(path, "w") as file:
        file.writelines(" ".join(words) + "\n" for words in lines)


def write_thinned(log, path):
    """Writes a scan per meter, or per half a radian."""
    chosen, last = [], None
    for words in laser_lines(log):
        first = after_ranges(words)
        x, y, yaw = (float(word) for word in words[first:first + 3])
        if last:
            turn = abs(math.remainder(yaw - last[2], 2.0 * math.pi))
            if math.dist((x, y), last[:2]) < STEP_M and turn < STEP_RAD:
                continue
        last = (x, y, yaw)
        chosen.append(words)
    write_lines(path, chosen)


def write_backward(log, path):
    """Writes the scans in reverse order. Returns the time at which the log ends."""
    lines = list(laser_lines(log))
    end = float(lines[-1][after_ranges(lines[-1]) + 6])
    for words in lines:
        stamp = after_ranges(words) + 6
        words[stamp] = words[-1] = f"{end - float(words[stamp]):.6f}"
    write_lines(path, reversed(lines))
    return end


def write_with_parts(log, path):
    """Writes the scans as a laser would have made them that sees three parts of its vehicle."""
    random_m = random.Random(1)
    lines = list(laser_lines(log))
    for words in lines:
        beams = int(words[1])
        for center in PARTS:
            for i in range(round((center - PART_SHARE / 2) * beams),
                           round((center + PART_SHARE / 2) * beams)):
                words[2 + i] = f"{random_m.gauss(PART_M, 0.005):.3f}"
    write_lines(path, lines)


def write_trajectory_backward(reference, path, end):
    with open(reference) as file:
        poses = [line.split() for line in file if line.strip() and not line.startswith("#")]
    write_lines(path, ([f"{end - float(stamp):.6f}", *pose] for stamp, *pose in reversed(poses)))


class AlteredRecording:
    """A recording of the folder freiburg. The reference is its trajectory as it was recorded, with
    all scans."""

    def __init__(self, bench, log, kind):
        self.bench, self.name = bench, f"{log}_{kind}"
        whole = f"freiburg/{log}.clf.bz2"
        folder = os.path.abspath(bench.map(whole, f"{log}_whole"))
        self.recorded = f"{bench.data}/{whole}"
        self.reference, self.altered = f"{folder}/trajectory.tum", f"{folder}/{kind}.clf"

    def runs(self, name, *options):
        """The states with each start."""
        def from_start(start):
            folder = f"{self.name}_{name}_{start}"
            self.bench.map(self.altered, folder, "--skip-scans", str(start), *options)
            return self.bench.states(folder, self.reference)

        return self.bench.at_once(from_start, STARTS)


def thinned(bench, log):
    recording = AlteredRecording(bench, log, "thinned")
    write_thinned(recording.recorded, recording.altered)
    return recording


def with_parts(bench, log):
    recording = AlteredRecording(bench, log, "parts")
    write_with_parts(recording.recorded, recording.altered)
    return recording


def backward(bench, log):
    recording = AlteredRecording(bench, log, "backward")
    end = write_backward(recording.recorded, recording.altered)
    forward, recording.reference = recording.reference, f"{recording.altered}.tum"
    write_trajectory_backward(forward, recording.reference, end)
    return recording
