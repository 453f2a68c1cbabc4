# SPDX-License-Identifier: BSD-3-Clause
"""tracking_table.py --build DIR --data DIR --output DIR [--only TEXT] [--quick] [--seeds N]: tracks
what moves in recordings and simulated scenes with default parameters, and prints a table of goals
and values. scripts/benchmark_tracking calls it."""
import collections
import csv
import math
import os
import re
import statistics
import subprocess
import sys
import tarfile
from concurrent.futures import ThreadPoolExecutor

import benchmark_table
import goal_table
from goal_table import percent, row

LASER_POSE = "--laser-pose=-0.165,0,0"  # behind the captured body; two_robots has it in its tf
RANGE_CORRECTION = ["--set", "range_correction=3.86:0.14, 4.27:0.23, 4.66:0.345, 5.04:0.465, "
                    "5.55:0.45, 6.1:0.4, 6.62:0.38"]
# Runs that differ only in what should not matter. A single one says little.
VARIANTS = [[], ["--imu", "none"], ["--filter", "none"], RANGE_CORRECTION,
            [*RANGE_CORRECTION, "--imu", "none"], ["--drop-beams", "0.05"],
            ["--drop-beams", "0.05", "--drop-beams-seed", "2"]]
# The axes of the captured body of two_robots are turned against those of the vehicle.
BODY_POSE = ["--sensor-pose", "0,0,6"]
CAPTURED = {  # recording: topic of the sensor, topics of the objects, options to track and evaluate
    "overtakes": ("/ego_pose", ["/red_pose"], [LASER_POSE], []),
    "parallel": ("/ego_pose", ["/red_pose"], [LASER_POSE], []),
    "two_robots": ("/mocap_pose", ["/robot_1", "/robot_2"], [], BODY_POSE),
}
# Other heights of the lidar than that of the scene change nothing that matters, only the pose by
# millimeters.
HEIGHTS = {"crossing": [1.85, 1.9, 1.92, 1.95], "street": [1.6, 1.73, 1.85, 2.0]}
MOTA_GOAL = {"crossing": 85.0, "street": 80.0}
IOU_GOAL = {"crossing": 85.0, "street": 75.0}
# Largest, mean and standard deviation in tables 5 and 6 of [Siew 2018].
PAPER = {
    "change of roll, rad": (0.0019, 4.3364e-05, 5.0803e-04),
    "change of pitch, rad": (0.0018, 3.3591e-05, 5.8129e-04),
    "change of yaw, rad": (0.0003, 5.7978e-06, 1.0226e-04),
    "change of x, m": (0.0804, 0.0013, 0.0363),
    "change of y, m": (0.0248, 0.0071, 0.0056),
    "change of z, m": (0.0383, 0.0023, 0.0107),
    "pose roll, rad": (0.0088, 0.0045, 0.0030),
    "pose pitch, rad": (0.0068, 0.0033, 0.0016),
    "pose yaw, rad": (0.0026, 7.2384e-04, 7.9103e-04),
    "pose x, m": (0.4494, 0.1347, 0.2067),
    "pose y, m": (1.4061, 0.6018, 0.4636),
    "pose z, m": (0.6519, 0.3973, 0.1991),
}


class Benchmark:
    def __init__(self, arguments):
        self.build, self.data, self.output = arguments.build, arguments.data, arguments.output
        self.seeds = arguments.seeds
        self.pool = ThreadPoolExecutor(arguments.jobs)

    def run(self, tool, *options):
        """What a tool prints."""
        print(tool, *options[:3], file=sys.stderr, flush=True)
        return subprocess.run([f"{self.build}/{tool}", *map(str, options)], check=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout

    def track(self, recording, name, *options):
        """Tracks with a planar laser, and returns the folder with the files."""
        folder = f"{self.output}/{name}"
        self.run("track_recording", f"{self.data}/{recording}", "--output", folder, "--quiet",
                 *options)
        return folder

    def evaluate(self, folder, recording, *options):
        path = f"{folder}/evaluation.json"
        self.run("evaluate_tracks", folder, f"{self.data}/{recording}", "--json", path, *options)
        return benchmark_table.load(path)

    def extract(self, archive):
        folder = f"{self.output}/{archive.split('.')[0]}"
        with tarfile.open(f"{self.data}/cloud/{archive}") as files:
            files.extractall(folder)
        return folder

    def at_once(self, function, items):
        return list(self.pool.map(function, items))


def cells_of(text):
    """The rows of the tables in a text, by their first cell."""
    lines = [line.strip("| \n").split(" | ") for line in text.splitlines() if line.startswith("|")]
    return {cells[0]: cells[1:] for cells in lines}


def number(text):
    return float(re.match(r"-?[\d.]+", text.strip()).group())


def phd_filter(bench):
    text = bench.run("measure_tracking", "--no-people")
    cells = cells_of(text)
    for name in ["heavy components", "labeled targets"]:
        ospa = number(cells[f"standard births, {name}"][1])
        row(f"PHD filter, standard births, {name}, 100 runs", "OSPA ≤ 21.3 m", f"{ospa:.1f} m",
            ospa <= 21.3)
    found = [int(n) for n in re.search(r"3 scans: (\d+) and (\d+)", text).groups()]
    row("spawned target", "found within 3 scans in 90 of 100 runs", f"{found[0]}, {found[1]}",
        min(found) >= 90)


def wheelchair(bench):
    recording = "moving/people_wheelchair.bag"
    folder = bench.track(recording, "wheelchair", "--odometry", "use")
    result = bench.evaluate(folder, recording, "--sensor-pose", "0.850326,0.235214,42.1",
                            "--bearings=-90,20")
    for name, goal in [("all", 0.30), ("moving", 0.55)]:
        r = result[name]
        row(f"people_wheelchair, with odometry, {name} people",
            f"MOTA ≥ {100 * goal:.0f} %; MOTP ≤ 0.15 m; ≤ 5 switches",
            f"{100 * r['mota']:.0f} %; {r['motp_m']:.2f} m; {r['switches']} switches",
            r["mota"] >= goal and r["motp_m"] <= 0.15 and r["switches"] <= 5)


def shown(folder):
    """The number of scans in which each track is shown, by its number."""
    with open(f"{folder}/tracks.csv", newline="") as file:
        return collections.Counter(track["id"] for track in csv.DictReader(file)
                                   if track["shown"] == "1")


def legs(bench):
    nobody = shown(bench.track("legs/negative_2.bag", "negative_2"))
    row("legs, negative_2: nobody", "no track that moves", f"{len(nobody)} tracks",
        not nobody)
    for name in ["positive_1", "positive_2", "positive_3"]:
        folder = bench.track(f"legs/{name}.bag", name)
        tracks, scans = shown(folder), benchmark_table.load(f"{folder}/stats.json")["scans"]["read"]
        longest = max(tracks.values(), default=0)
        row(f"legs, {name}: one walker", "one identity for 95 % of the time",
            f"the longest for {longest} of {scans} scans; {len(tracks)} in all",
            longest >= 0.95 * scans)


def motion_capture(bench):
    for name, (sensor, objects, options, evaluation) in CAPTURED.items():
        recording = f"moving/{name}.bag"
        topics = [option for topic in objects for option in ("--topic", topic)]

        def measure(item):
            folder = bench.track(recording, f"{name}_{item[0]}", *options, *item[1])
            return bench.evaluate(folder, recording, "--sensor-topic", sensor, *topics,
                                  *evaluation)

        results = bench.at_once(measure, enumerate(VARIANTS))

        def errors(of):
            return [statistics.mean(r[key] for r in of)
                    for key in ("position_rmse_m", "velocity_rmse_m_s")]

        position, speed = errors(results)
        corrected = errors([r for r, variant in zip(results, VARIANTS)
                            if variant[:2] == RANGE_CORRECTION])
        motas = sorted(100 * r["moving"]["mota"] for r in results)
        row(f"motion capture, {name}, mean of {len(results)} runs",
            "position ≤ 0.10 m; speed ≤ 0.15 m/s",
            f"{position:.2f} m; {speed:.2f} m/s; MOTA {statistics.mean(motas):.0f} % "
            f"({motas[0]:.0f} to {motas[-1]:.0f}); with the range correction "
            f"{corrected[0]:.2f} m, {corrected[1]:.2f} m/s", position <= 0.10 and speed <= 0.15)


def people(bench):
    def fly(seed):
        return cells_of(bench.run("measure_tracking", "--runs", 1, "--seed", seed))["twelve people"]

    flights = bench.at_once(fly, range(1, bench.seeds + 1))

    def mean(column):
        return statistics.mean(number(cells[column]) for cells in flights)

    row(f"flight among twelve people, mean of {bench.seeds} seeds",
        "MOTA ≥ 95 %; ≤ 8 switches; speed ≤ 0.1 m/s",
        f"{mean(0):.1f} %; {mean(4):.1f}; {mean(5):.2f} m/s; {mean(2):.0f} misses, "
        f"{mean(3):.0f} false", mean(0) >= 95 and mean(4) <= 8 and mean(5) <= 0.1)
    ghosts, ates = ([cells[i].split(", ") for cells in flights] for i in (6, 7))
    most = [max(number(g[i]) for g in ghosts) for i in (0, 1)]
    worst = [max(number(a[i]) for a in ates) for i in (0, 1)]
    row("the same: occupied cells left by people", "0",
        f"at most {most[0]:.0f} ({most[1]:.0f} without the tracker)", most[0] == 0)
    row("the same: ATE", "not worse than without the tracker",
        f"worst {worst[0]:.3f} m ({worst[1]:.3f} m without the tracker)", worst[0] <= worst[1])


def scene(bench, name, *options):
    """The figures of a simulated scene."""
    text = bench.run("measure_tracking_3d", "--only", name, *options)
    cells = cells_of(text)
    change = re.search(r"change of pose: ([\d.]+) m, ([\d.]+) deg", text)
    return {"mota": number(cells["all"][1]), "false": int(cells["all"][4]),
            "switches": int(cells["all"][5]), "iou": number(re.search(r"IoU (.*)", text)[1]),
            "change_m": float(change[1]), "change_deg": float(change[2]), "cells": cells}


def scene_row(measure, name, r):
    row(measure, f"MOTA ≥ {MOTA_GOAL[name]:.0f} %; IoU of moving points ≥ {IOU_GOAL[name]:.0f} %",
        f"{r['mota']:.1f} %; {r['iou']:.1f} %; {r['false']} false, {r['switches']} switches; "
        f"largest error of a change of pose {r['change_m']:.4f} m, {r['change_deg']:.3f}°",
        r["mota"] >= MOTA_GOAL[name] and r["iou"] >= IOU_GOAL[name])


def traffic(bench):
    crossing, street = bench.at_once(lambda name: scene(bench, name), ["crossing", "street"])
    scene_row("crossing, HDL-32E that stands", "crossing", crossing)
    row("the same: change of the pose", "< 0.01 m, 0.05°",
        f"{crossing['change_m']:.4f} m, {crossing['change_deg']:.4f}°",
        crossing["change_m"] < 0.01 and crossing["change_deg"] < 0.05)
    scene_row("street, HDL-64E that drives", "street", street)
    above = [name for name, limits in PAPER.items()
             if any(abs(float(cell)) > limit for cell, limit in zip(street["cells"][name], limits))]
    row("the same: errors of tables 5 and 6 of [Siew 2018]", "none above",
        ", ".join(above) if above else f"none of {3 * len(PAPER)} above", not above)


def other_traffic(bench):
    items = [(name, height) for name in HEIGHTS for height in HEIGHTS[name]]
    results = bench.at_once(lambda item: scene(bench, item[0], "--height", item[1]), items)
    for name in HEIGHTS:
        motas = [r["mota"] for item, r in zip(items, results) if item[0] == name]
        mean = statistics.mean(motas)
        row(f"{name}, four heights of the lidar", f"mean MOTA ≥ {MOTA_GOAL[name]:.0f} %",
            f"{mean:.1f} % ({min(motas):.1f} to {max(motas):.1f})", mean >= MOTA_GOAL[name])
    others = [("crossing", "hdl64e"), ("street", "hdl32e"), ("street", "vlp16")]
    for item, r in zip(others, bench.at_once(
            lambda item: scene(bench, item[0], "--lidar", item[1]), others)):
        scene_row(f"{item[0]}, {item[1]}", item[0], r)


def reference_of(path, name, stamps, output):
    """Writes one of the references of gt_poses.csv as a TUM file with the stamps of the sweeps."""
    with open(path, newline="") as file, open(output, "w") as tum:
        poses = [pose for pose in csv.DictReader(file) if pose["ref"] == name]
        for stamp, p in zip(stamps, poses):
            tum.write(" ".join([stamp, *(p[k] for k in "x y z qx qy qz qw".split())]) + "\n")


def rows_of(path):
    with open(path) as file:
        return [line.split() for line in file if line.strip() and line[0] != "#"]


def changes_of_pose(path):
    """The largest change from one pose of a TUM file to the next, m and degrees."""
    poses = [[float(value) for value in pose[1:]] for pose in rows_of(path)]
    meters, degrees = [], []
    for a, b in zip(poses, poses[1:]):
        meters.append(math.dist(a[:3], b[:3]))
        cosine = min(1.0, abs(sum(p * q for p, q in zip(a[3:], b[3:]))))
        degrees.append(math.degrees(2.0 * math.acos(cosine)))
    return max(meters), max(degrees)


def kitti(bench):
    labels, folder = bench.extract("kitti_tracking_text.tar.xz"), f"{bench.output}/kitti"
    text = bench.run("track_clouds", f"{bench.data}/cloud/kitti0000_slice.bag", "--output", folder,
                     "--labels", f"{labels}/label/0000.txt", "--calibration",
                     f"{labels}/calib/0000.txt")
    reference_of(f"{bench.data}/cloud/gt_poses.csv", "orb_scaled",
                 [pose[0] for pose in rows_of(f"{folder}/trajectory.tum")], f"{folder}/reference.tum")
    ate = benchmark_table.evaluate(bench.build, folder, "--reference",
                                   f"{folder}/reference.tum")["reference"]["ate"]
    error = ate["translation_m"]["mean"]
    lost = re.search(r"(\d+) of them without localization", text)
    row("kitti0000_slice, trajectory", "ATE ≤ 0.078 m",
        f"mean {error:.3f} m, {ate['rotation_deg']['mean']:.2f}°; sweeps without localization: "
        f"{lost[1] if lost else 0}", error <= 0.078)
    for line in re.findall(r"^ +\d+ +[A-Z][a-z]+ +[\d.]+ +\d+ +[\d.]+%.*$", text, re.MULTILINE):
        label, kind, _, sweeps, share = line.split()[:5]
        row(f"kitti0000_slice, {kind} {label}", "shown in 80 % of its sweeps",
            f"{share.replace('%', ' %')} of {sweeps}", number(share) >= 80)


def standing(bench):
    folder = bench.extract("hdl64e_standing_11_frames.tar.xz") + "/data_bin"
    output = f"{bench.output}/standing_tracks"
    bench.run("track_clouds", *sorted(f"{folder}/{name}" for name in os.listdir(folder)),
              "--output", output)
    meters, degrees = changes_of_pose(f"{output}/trajectory.tum")
    row("HDL-64E that stands, 11 sweeps", "change of pose < 0.02 m, 0.1°",
        f"at most {meters:.3f} m, {degrees:.2f}°", meters < 0.02 and degrees < 0.1)


# name: function, whether it takes long
GROUPS = {
    "PHD filter": (phd_filter, False),
    "people_wheelchair": (wheelchair, False),
    "legs": (legs, False),
    "motion capture": (motion_capture, False),
    "flight among people": (people, False),
    "traffic": (traffic, False),
    "other heights and lidars": (other_traffic, True),
    "KITTI": (kitti, False),
    "standing HDL-64E": (standing, False),
}


if __name__ == "__main__":
    goal_table.run(__doc__, GROUPS, Benchmark, {"seeds": 8})
