# SPDX-License-Identifier: BSD-3-Clause
"""Runs a batch on a Slurm cluster: an array with a task per recording, and then the summary.

A task that ends without a result (a node failed, or the time limit of the cluster came) is submitted
anew. A result that says that the recording failed is a result."""

import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import time

from . import BatchError, report, task
from .tools import read_json, write_json

ROUNDS = 3  # how often a task without a result is submitted
POLL = 1.0  # s
LARGEST_ARRAY = 1000  # tasks; the default limit of Slurm is 1001
SPARE_MINUTES = 2  # above the time limit of the batch, so that the task itself ends the program


def run_all(plan, arguments, script):
    """Submits and waits. If this process ends, the jobs go on: --resume collects their results."""
    if not shutil.which("sbatch"):
        raise BatchError("--slurm: sbatch is not installed on this machine")
    folder = pathlib.Path(plan["output"])
    (folder / "slurm").mkdir(exist_ok=True)
    for number in range(ROUNDS):
        missing = todo_of(plan, again=number == 0)
        if not missing:
            break
        if not arguments.quiet:
            print(f"submitting {len(missing)} recordings to Slurm", flush=True)
        jobs = [submit(folder, missing[first:first + LARGEST_ARRAY], f"{number}_{first}", arguments,
                       script) for first in range(0, len(missing), LARGEST_ARRAY)]
        wait_for(submit_summary(folder, jobs, arguments, script), plan, arguments.quiet)


def todo_of(plan, again):
    """Numbers of recordings without a result; with `again` those that failed too."""
    numbers = []
    for number, recording in enumerate(plan["recordings"]):
        result = task.result_of(plan, recording)
        if result is None or (again and result["status"] != "ok"):
            numbers.append(number)
    return numbers


def submit(folder, numbers, name, arguments, script):
    """Submits an array; returns the number of its job."""
    listing = folder / "slurm" / f"tasks_{name}.json"
    write_json(listing, numbers)
    minutes = int(arguments.timeout / 60.0) + SPARE_MINUTES
    options = [f"--array=0-{len(numbers) - 1}" + (f"%{arguments.jobs}" if arguments.jobs else ""),
               f"--time={minutes}", "--cpus-per-task=1", "--no-requeue"]
    if arguments.memory:
        options.append(f"--mem={round(arguments.memory)}")
    return sbatch(folder, arguments.slurm, options,
                  [sys.executable, str(script), "slurm-task", str(folder), str(listing)])


def submit_summary(folder, jobs, arguments, script):
    """The tables are written even if nobody waits."""
    return sbatch(folder, arguments.slurm, ["--dependency=afterany:" + ":".join(jobs)],
                  [sys.executable, str(script), "slurm-summary", str(folder)])


def sbatch(folder, partition, options, command):
    options = ["sbatch", "--parsable", "--job-name=map_batch", "--export=ALL",
               f"--output={folder}/slurm/%A_%a.log", *options]
    if partition:
        options.append(f"--partition={partition}")
    run = subprocess.run([*options, "--wrap", shlex.join(command)], capture_output=True, text=True,
                         check=False)
    if run.returncode != 0:
        raise BatchError(f"sbatch: {run.stderr.strip()}")
    return run.stdout.strip().split(";")[0]


def wait_for(job, plan, quiet):
    """Asks squeue, because `sbatch --wait` asks seldom. The summary is the last job."""
    total, said, pause = len(plan["recordings"]), -1, POLL
    while is_queued(job):
        time.sleep(pause)
        begin = time.monotonic()
        done = total - len(todo_of(plan, again=False))
        pause = max(POLL, 10.0 * (time.monotonic() - begin))  # thousands of results take seconds
        if not quiet and done != said:
            print(f"{done}/{total} recordings have a result", file=sys.stderr, flush=True)
        said = done


def is_queued(job):
    """A controller that does not answer is asked again: its tasks may still run."""
    run = subprocess.run(["squeue", "--noheader", "--jobs", job], capture_output=True, text=True,
                         check=False)
    if run.returncode != 0:
        return "Invalid job id" not in run.stderr
    return bool(run.stdout.strip())


def run_task(folder, listing):
    """One task of the array, on a node. Exit code 0 if there is a result, even if it says that the
    recording failed."""
    plan = read_json(pathlib.Path(folder) / "batch.json")
    number = read_json(listing)[int(os.environ["SLURM_ARRAY_TASK_ID"])]
    result = task.run(plan, plan["recordings"][number])
    print(f"{result['name']}: {result['status']} {result['message']}")
    return 0


def summarize(folder):
    report.write_and_print(read_json(pathlib.Path(folder) / "batch.json"))
    return 0


COMMANDS = {"slurm-task": run_task, "slurm-summary": summarize}
