# SPDX-License-Identifier: BSD-3-Clause
"""Maps one recording in processes of its own, and puts the results into their place."""

import glob
import hashlib
import json
import os
import pathlib
import re
import resource
import select
import shutil
import signal
import socket
import subprocess
import sys
import time

from .tools import read_json, write_json

MEGABYTE = 1 << 20
RESULT = "result.json"
POLL = 0.2  # how often time and signals are looked at, s


class Stopped(Exception):
    """The batch was asked to stop."""


def key_of(plan, recording):
    """A result belongs to its input, options and program. If one of them is another, the recording
    is mapped again."""
    files = recording["files"] + [recording[what] for what in ("relations", "reference")
                                  if recording[what]]
    states = [[pathlib.Path(file).name, os.stat(file).st_size, os.stat(file).st_mtime_ns]
              for file in files if os.path.exists(file)]
    parts = [states, recording["reference_topic"], plan["options_key"], plan["tools_hash"]]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def result_of(plan, recording):
    """The complete result of a recording that is already there, or None."""
    result = read_json(folder_of(plan, recording) / RESULT)
    return result if result and result.get("key") == key_of(plan, recording) else None


def folder_of(plan, recording):
    return pathlib.Path(plan["output"]) / "maps" / recording["name"]


def run(plan, recording, stop=lambda: False):
    """Maps, evaluates, and renames the folder into its place. Returns the result."""
    target = folder_of(plan, recording)
    target.parent.mkdir(parents=True, exist_ok=True)
    for left in target.parent.glob(f".{glob.escape(target.name)}.work*"):  # by a killed process
        shutil.rmtree(left, ignore_errors=True)
    work = target.parent / f".{target.name}.work-{socket.gethostname()}-{os.getpid()}"
    work.mkdir()
    try:
        result = map_into(work, plan, recording, stop)
        write_json(work / RESULT, result)
        replace_folder(work, target)
        return result
    finally:
        shutil.rmtree(work, ignore_errors=True)


def map_into(work, plan, recording, stop):
    tools, maps = pathlib.Path(plan["tools"]), work / "map"
    result = {"name": recording["name"], "files": recording["files"],
              "key": key_of(plan, recording), "status": "ok", "message": ""}
    command = [str(tools / "map_recording"), *plan["options"], "--quiet", "--output", str(maps),
               "--", *recording["files"]]
    with open(work / "log.txt", "wb") as log:
        outcome = Process(command, log, plan, stop).wait()
        result.update(outcome)
        if result["status"] == "ok":
            result.update(evaluate(maps, tools, recording, log, plan, stop))
            result.update(count_instructions(work, command, log, plan, stop))
    if maps.is_dir():
        for file in maps.iterdir():
            os.rename(file, work / file.name)
        maps.rmdir()
    return result


def evaluate(maps, tools, recording, log, plan, stop):
    """Errors against the ground truth, if there is one."""
    command = [str(tools / "evaluate_trajectory"), str(maps / "trajectory.tum"),
               "--json", str(maps / "evaluation.json")]
    if recording["relations"]:
        command += ["--relations", recording["relations"]]
    if recording["reference"]:
        command += ["--reference", recording["reference"], "--scans", str(maps / "scans.csv")]
        if recording["reference_topic"]:
            command += ["--reference-topic", recording["reference_topic"]]
    if not recording["relations"] and not recording["reference"]:
        return {}
    outcome = Process(command, log, plan, stop).wait()
    if outcome["status"] == "ok":
        return {}
    (maps / "evaluation.json").unlink(missing_ok=True)
    return {"message": "the ground truth could not be used: " + outcome["message"]}


def count_instructions(work, command, log, plan, stop):
    """Millions of instructions for the first scans: the same on every machine, however busy."""
    if not plan["instructions"]:
        return {}
    report = work / "instructions.txt"
    mapping = [str(work / "counted") if part == str(work / "map") else part for part in command]
    if "--scans" in mapping:
        first = mapping.index("--scans")
        del mapping[first:first + 2]
    place = mapping.index("--")
    mapping[place:place] = ["--scans", str(plan["instructions"])]
    outcome = Process(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
                       f"--log-file={report}", *mapping], log, plan, stop).wait()
    shutil.rmtree(work / "counted", ignore_errors=True)
    if outcome["status"] != "ok":
        return {"message": "the instructions could not be counted: " + outcome["message"]}
    found = re.search(r"Collected : (\d+)", report.read_text())
    report.unlink()
    return {"instructions_million": round(int(found.group(1)) / 1e6, 1)}


def replace_folder(source, target):
    """After a kill between the two steps the result is missing, and is made again."""
    shutil.rmtree(target, ignore_errors=True)
    os.rename(source, target)


class Process:
    """A program with limits of time and memory, in a process group of its own."""

    def __init__(self, command, log, plan, stop):
        self._plan, self._stop, self._log = plan, stop, log
        self._begin = time.monotonic()
        # setpriv: the program ends with this process, even if that is killed.
        self._process = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", "--", *command],
                                         stdin=subprocess.DEVNULL, stdout=log,
                                         stderr=subprocess.STDOUT, start_new_session=True)
        self._limit(resource.RLIMIT_DATA, int(plan["memory_mb"] * MEGABYTE))
        self._limit(resource.RLIMIT_CORE, 0)

    def _limit(self, what, value):
        """From here, because one more program in between would cost a millisecond each."""
        try:
            hard = resource.prlimit(self._process.pid, what)[1]
            value = min(value, sys.maxsize if hard == resource.RLIM_INFINITY else hard)
            resource.prlimit(self._process.pid, what, (value, value))
        except ProcessLookupError:
            pass  # it has already ended

    def wait(self):
        """{"status": ..., "message": ...}"""
        if not hasattr(os, "pidfd_open"):  # Python 3.8 of ROS Noetic: notices the end a little later
            return self._watch(self._has_ended)
        file = os.pidfd_open(self._process.pid)
        try:
            return self._watch(lambda: select.select([file], [], [], POLL)[0])
        finally:
            os.close(file)

    def _has_ended(self):
        try:
            self._process.wait(POLL)
            return True
        except subprocess.TimeoutExpired:
            return False

    def _watch(self, has_ended):
        while not has_ended():
            if self._stop():
                self._kill()
                raise Stopped()
            if time.monotonic() - self._begin > self._plan["timeout_s"]:
                self._kill()
                return {"status": "timeout", "message":
                        f"was stopped after {self._plan['timeout_s']:g} s (--timeout)"}
        return self._outcome(self._process.wait())

    def _kill(self):
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def _outcome(self, code):
        if code == 0:
            return {"status": "ok", "message": ""}
        last = last_line(self._log.name)
        if "bad_alloc" in last:
            return {"status": "memory", "message":
                    f"needs more than {self._plan['memory_mb']:g} MB (--memory)"}
        if code < 0:
            name = signal.Signals(-code).name
            more = "; perhaps the memory of the machine was full" if code == -signal.SIGKILL else ""
            return {"status": "crashed", "message": f"ended by {name}{more}"}
        return {"status": "failed", "message": last or f"exit code {code}"}


def last_line(path):
    """The last line of a log that is no warning, without the name of the program."""
    lines = pathlib.Path(path).read_text(encoding="utf-8", errors="replace").strip().splitlines()
    lines = [line for line in lines if not line.startswith("warning:")] or lines
    return re.sub(r"^\w+: ", "", lines[-1]) if lines else ""
