# SPDX-License-Identifier: BSD-3-Clause
"""Runs a batch on this machine: some recordings at a time, with one progress bar for all."""

import concurrent.futures
import os
import signal
import sys
import threading
import time

from . import task

BAR = 24  # characters
REDRAW = 0.5  # s
SMALLEST_MEMORY = 512.0  # MB


def memory_per_job(jobs):
    """The free memory is shared, so that one recording cannot stop the others."""
    with open("/proc/meminfo", encoding="ascii") as file:
        values = dict(line.split(":") for line in file)
    free = int(values["MemAvailable"].split()[0]) / 1024.0
    return round(max(SMALLEST_MEMORY, free / jobs))


def run_all(plan, jobs, quiet):
    """Maps every recording that has no complete result. A failed one is tried again."""
    todo = []
    for recording in plan["recordings"]:
        result = task.result_of(plan, recording)
        if result is None or result["status"] != "ok":
            todo.append(recording)
    kept = len(plan["recordings"]) - len(todo)
    if kept and not quiet:
        print(f"{kept} of {len(plan['recordings'])} recordings are already mapped")
    stop = threading.Event()
    handlers = [signal.signal(number, lambda *_: stop.set())
                for number in (signal.SIGINT, signal.SIGTERM)]
    try:
        run_some(plan, todo, jobs, stop, Progress(todo, quiet))
    finally:
        for number, handler in zip((signal.SIGINT, signal.SIGTERM), handlers):
            signal.signal(number, handler)
    if stop.is_set():
        raise KeyboardInterrupt


def run_some(plan, todo, jobs, stop, progress):
    def run_one(recording):
        if stop.is_set():
            return
        progress.begin(recording)
        try:
            progress.end(recording, task.run(plan, recording, stop.is_set))
        except task.Stopped:
            pass

    # The largest files first: so no long one is left to one core at the end.
    ordered = sorted(todo, key=size_of, reverse=True)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        futures = [pool.submit(run_one, recording) for recording in ordered]
        while concurrent.futures.wait(futures, REDRAW).not_done:
            progress.draw()
    progress.finish()
    for future in futures:
        future.result()  # an error of the disk ends the batch with its message


def size_of(recording):
    return sum(os.path.getsize(file) for file in recording["files"] if os.path.exists(file))


class Progress:
    """On a terminal a bar, and a line for each recording that failed. Otherwise a line for every
    recording."""

    def __init__(self, todo, quiet):
        self._quiet, self._terminal = quiet, sys.stderr.isatty()
        self._total, self._bytes = len(todo), sum(map(size_of, todo))
        self._done = self._done_bytes = self._failed = 0
        self._running = []
        self._begin = time.monotonic()
        self._lock = threading.Lock()

    def begin(self, recording):
        with self._lock:
            self._running.append(recording["name"])

    def end(self, recording, result):
        with self._lock:
            self._running.remove(recording["name"])
            self._done += 1
            self._done_bytes += size_of(recording)
            failed = result["status"] != "ok"
            self._failed += failed
            if self._quiet or (self._terminal and not failed):
                return
            self._clear()
            message = f": {result['message']}" if result["message"] else ""
            print(f"{self._done}/{self._total} {result['name']}: {result['status']}{message}",
                  file=sys.stderr, flush=True)

    def draw(self):
        if not self._terminal or self._quiet:
            return
        with self._lock:
            self._clear()
            print(self._text()[:terminal_width() - 1], end="", file=sys.stderr, flush=True)

    def finish(self):
        if self._terminal and not self._quiet:
            self._clear()

    @staticmethod
    def _clear():
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr)

    def _text(self):
        full = round(BAR * self._done_bytes / max(self._bytes, 1))
        elapsed = time.monotonic() - self._begin
        text = f"[{'#' * full}{' ' * (BAR - full)}] {self._done}/{self._total}"
        if self._failed:
            text += f", {self._failed} failed"
        if self._done_bytes:
            left = elapsed * (self._bytes / self._done_bytes - 1.0)
            text += f", {clock(left)} left"
        return text + "  " + " ".join(self._running)


def clock(seconds):
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{seconds:02d}" if minutes >= 60 else \
        f"{minutes}:{seconds:02d}"


def terminal_width():
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns
    except OSError:
        return 80
