# SPDX-License-Identifier: BSD-3-Clause
"""Finds the recordings of a batch, the bags that belong together, and the ground truth."""

import collections
import concurrent.futures
import dataclasses
import fnmatch
import json
import os
import pathlib
import re
import subprocess

from . import BatchError

PACKED = (".bz2", ".gz", ".xz")
ENDINGS = (".bag", ".clf", ".log", ".csv", ".dat", ".txt")
# A file with one of these names was meant as a recording, even if it is damaged or of ROS 2.
# map_recording says what is wrong with it.
MEANT = (".bag", ".bag.active", ".clf", ".db3", ".mcap")
FILES_PER_CALL = 100
# A bag that begins at most so long after the end of the bag before it is its next part, s. The first
# message of a part may be older than the last one before it: they come from several threads.
LONGEST_GAP = 2.0
LONGEST_OVERLAP = 0.1

DEFAULT_RULES = ("relations:{name}.relations", "reference:{name}.reference.tum",
                 "reference:{name}.truth.tum", "reference:{name}_truth.tum",
                 "topic:*ground_truth*", "topic:*groundtruth*")
POSE_TYPES = ("geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped",
              "nav_msgs/Odometry")


@dataclasses.dataclass
class Recording:
    """One line of the table."""
    name: str
    files: list
    relations: str = ""
    reference: str = ""
    reference_topic: str = ""


def stem(path):
    """The name of a file without the endings of recordings: flight.bag.bz2 is flight."""
    name = pathlib.Path(path).name
    for endings in (PACKED, (".active",), ENDINGS):
        for ending in endings:
            if name.lower().endswith(ending) and len(name) > len(ending):
                name = name[:-len(ending)]
                break
    return name


def is_meant(path):
    name = path.name.lower()
    return name.endswith(MEANT) or any(name.endswith(ending + packed)
                                       for ending in (".bag", ".clf") for packed in PACKED)


def info_of(tools, paths):
    """What recording_info says about each file."""
    cores = len(os.sched_getaffinity(0))
    size = max(1, min(FILES_PER_CALL, -(-len(paths) // cores)))
    parts = [[str(path) for path in paths[first:first + size]]
             for first in range(0, len(paths), size)]

    def ask(part):
        run = subprocess.run([str(tools / "recording_info"), "--json", "--quick", "--", *part],
                             capture_output=True, text=True, check=False)
        lines = run.stdout.splitlines()
        if run.returncode != 0 and len(part) > 1:  # one of them ended it
            return [pair for path in part for pair in ask([path])]
        return list(zip(part, map(json.loads, lines)))

    with concurrent.futures.ThreadPoolExecutor(cores) as pool:
        return dict(pair for pairs in pool.map(ask, parts) for pair in pairs)


class Finder:
    """Turns the arguments of map_batch into recordings."""

    def __init__(self, tools, rules):
        self._tools = tools
        self._rules = [parse_rule(rule) for rule in rules or DEFAULT_RULES]
        self._asked_for_truth = bool(rules)
        self._infos = {}

    def find(self, arguments):
        groups = []
        for argument in arguments:
            path = pathlib.Path(argument)
            if path.is_dir():
                groups += [(path, files) for files in self._in_folder(path)]
            elif not path.exists():
                raise BatchError(f"{path}: there is no such file or folder")
            elif self._info(path)["format"] or is_meant(path):
                groups.append((path.parent, [path]))
            else:
                groups += [(path.parent, files) for files in self._in_list(path)]
        recordings = [Recording("", [str(file) for file in files]) for _, files in groups]
        name_all(recordings, [root for root, _ in groups])
        if any(kind == "topic" for kind, _ in self._rules):
            self._load([recording.files[0] for recording in recordings])
        for recording in recordings:
            self._add_truth(recording)
        if self._asked_for_truth and not any(recording.relations or recording.reference
                                             for recording in recordings):
            raise BatchError(f"--truth: no recording has a ground truth by {self._places(recordings)}")
        return without_references(recordings)

    def _places(self, recordings):
        """Where the ground truth of the first recording would be."""
        first = pathlib.Path(recordings[0].files[0])
        return " or ".join(f"a topic {pattern}" if kind == "topic" else
                           f"a file such as {first.parent / pattern.format(name=stem(first))}"
                           for kind, pattern in self._rules)

    def _load(self, paths):
        """Many files at once: each start of a program takes as long as to look at several bags."""
        self._infos.update(info_of(self._tools,
                                   [path for path in paths if str(path) not in self._infos]))

    def _info(self, path):
        self._load([path])
        return self._infos.get(str(path), {"format": "", "topics": {}})

    def _in_folder(self, folder):
        """The recordings below a folder: groups of files."""
        results = {path.parent for path in folder.rglob("batch.json")}  # of other batches
        files = sorted(path for path in folder.rglob("*") if path.is_file()
                       and not results.intersection(path.parents)
                       and not any(part.startswith(".") for part in path.relative_to(folder).parts))
        self._load(files)
        chosen = [path for path in files if self._info(path)["format"] or is_meant(path)]
        if not chosen:
            raise BatchError(f"{folder}: there is no recording in this folder")
        return self._joined(chosen)

    def _in_list(self, path):
        """A line per recording: a file, a folder with its parts, or several parts."""
        groups = []
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except UnicodeDecodeError:
            raise BatchError(f"{path}: is no recording and no list of recordings") from None
        for number, line in enumerate(lines, 1):
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            groups.append(self._of_line(path.parent, line, f"{path}:{number}"))
        if not groups:
            raise BatchError(f"{path}: the list has no line with a recording")
        return groups

    def _of_line(self, folder, line, where):
        names = [line] if (folder / line).exists() else line.split()
        files = []
        for name in names:
            if (folder / name).is_dir():
                files += [file for group in self._in_folder(folder / name) for file in group]
            elif (folder / name).exists():
                files.append(folder / name)
            else:
                raise BatchError(f"{where}: {folder / name} does not exist")
        return files

    def _joined(self, paths):
        """Bags that follow each other by name (flight_0.bag, flight_1.bag) and without a pause by
        time are parts of one recording, as `rosbag record --split` writes them."""
        groups = []
        open_parts = {}  # by folder and name without date and number: (number, end, group)
        for path in sorted(paths, key=part_order):
            info, key, number = self._info(path), *part_of(path)
            before = open_parts.get(key)
            if (before and number == before[0] + 1
                    and -LONGEST_OVERLAP <= info.get("begin_s", 0.0) - before[1] <= LONGEST_GAP):
                group = before[2]
                group.append(path)
            else:
                group = [path]
                groups.append(group)
            if number is not None and info.get("end_s"):
                open_parts[key] = (number, info["end_s"], group)
        return sorted(groups)

    def _add_truth(self, recording):
        first = pathlib.Path(recording.files[0])
        names = dict.fromkeys([stem(first), part_of(first)[0][1], recording.name])
        for kind, pattern in self._rules:
            if kind == "topic":
                self._add_topic(recording, pattern)
                continue
            for name in names:
                path = first.parent / pattern.format(name=name)
                if path.is_file() and not getattr(recording, kind):
                    setattr(recording, kind, str(path))
                    if kind == "reference":
                        recording.reference_topic = ""

    def _add_topic(self, recording, pattern):
        if recording.reference or len(recording.files) > 1:
            return
        for topic, what in self._info(recording.files[0])["topics"].items():
            if fnmatch.fnmatch(topic, pattern) and what["type"] in POSE_TYPES and what["messages"]:
                recording.reference, recording.reference_topic = recording.files[0], topic
                return


def parse_rule(rule):
    kind, _, pattern = rule.partition(":")
    if kind not in ("relations", "reference", "topic") or not pattern:
        raise BatchError(f"--truth {rule}: a rule is relations:PATTERN, reference:PATTERN or "
                         "topic:PATTERN, such as reference:../truth/{name}.tum")
    try:
        pattern.format(name="")
    except (KeyError, IndexError, ValueError):
        raise BatchError(f"--truth {rule}: the only name in braces is {{name}}") from None
    return kind, pattern


def part_of(path):
    """((folder, name without date and number), number) of a split bag; the number may be None."""
    name = stem(path)
    match = re.fullmatch(r"(.*?)_?(\d{4}-\d\d-\d\d-\d\d-\d\d-\d\d)?_(\d+)", name)
    if match is None or ".bag" not in pathlib.Path(path).name:
        return (str(pathlib.Path(path).parent), name), None
    return (str(pathlib.Path(path).parent), match.group(1)), int(match.group(3))


def part_order(path):
    """By date, then by number (2 before 10)."""
    key, number = part_of(path)
    date = re.search(r"\d{4}-\d\d-\d\d-\d\d-\d\d-\d\d", path.name)
    return key, date.group(0) if date else "", -1 if number is None else number, str(path)


def name_all(recordings, roots):
    """Names of result folders: the path below the given folder, as short as it is unique."""
    paths = []
    for recording, root in zip(recordings, roots):
        first = pathlib.Path(recording.files[0])
        below = first.relative_to(root) if root in first.parents else pathlib.Path(first.name)
        paths.append(below)
        short = part_of(first)[0][1] if len(recording.files) > 1 else stem(first)
        recording.name = clean("__".join([*below.parts[:-1], short or stem(first)]))
    counts = collections.Counter(recording.name for recording in recordings)
    for recording, below in zip(recordings, paths):
        if counts[recording.name] > 1:
            recording.name = clean("__".join(below.parts))
    seen = {}
    for recording in recordings:
        seen[recording.name] = seen.get(recording.name, 0) + 1
        if seen[recording.name] > 1:
            recording.name += f"-{seen[recording.name]}"


def clean(name):
    """Names are parts of paths and links."""
    return re.sub(r"[^\w.+=-]", "_", name).lstrip(".") or "recording"


def without_references(recordings):
    """A bag that is the ground truth of another recording is none itself."""
    truths = {recording.reference for recording in recordings
              if recording.reference not in recording.files}
    return [recording for recording in recordings if recording.files[0] not in truths]
