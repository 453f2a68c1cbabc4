#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""map_batch with stand-ins for the programs, which crash, hang and eat memory by the name of the
recording. test/commands/map_batch_test.cpp maps real recordings."""

import json
import os
import pathlib
import pty
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
# pylint: disable=wrong-import-position
from batch_stand_ins import EVALUATE, MAP_RECORDING, RECORDING_INFO  # noqa: E402
from kestrel_batch import slurm  # noqa: E402

BATCH = str(ROOT / "scripts" / "map_batch")


class Batch(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)
        self.logs, self.out = self.folder / "logs", self.folder / "out"
        self.logs.mkdir()
        tools = self.folder / "tools"
        tools.mkdir()
        for name, text in (("map_recording", MAP_RECORDING), ("evaluate_trajectory", EVALUATE),
                           ("recording_info", RECORDING_INFO)):
            (tools / name).write_text(text)
            (tools / name).chmod(0o755)
        self.calls = self.folder / "calls"
        self.asked = self.folder / "asked"
        self.environment = {**os.environ, "KESTREL_TOOLS": str(tools), "CALLS": str(self.calls),
                            "ASKED": str(self.asked)}

    def tearDown(self):
        self._folder.cleanup()

    def log(self, name, error_mm=10, text="", relations=True):
        path = self.logs / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{error_mm}\n{text}")
        if relations:
            path.with_name(name.split("/")[-1].split(".")[0] + ".relations").write_text("")

    def batch(self, *options, code=0, **environment):
        run = subprocess.run([BATCH, str(self.logs), "--output", str(self.out), "--no-timing",
                              *options], capture_output=True, text=True, check=False,
                             env={**self.environment, **environment})
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout + run.stderr

    def summary(self, out=None):
        return json.loads(((out or self.out) / "summary.json").read_text())

    def row(self, name):
        return next(row for row in self.summary()["recordings"] if row["name"] == name)

    def names(self):
        return [row["name"] for row in self.summary()["recordings"]]

    def called(self):
        return sorted(self.calls.read_text().split()) if self.calls.exists() else []


class OneRecordingCannotEndTheBatch(Batch):
    def test_every_kind_of_failure_is_a_line(self):
        for name in ("crash", "hang", "memory", "broken", "good"):
            self.log(name + ".clf")
        text = self.batch("--timeout", "2", "--memory", "600", "-j", "3", code=1)
        self.assertEqual({name: self.row(name)["status"] for name in self.names()},
                         {"broken": "failed", "crash": "crashed", "good": "ok", "hang": "timeout",
                          "memory": "memory"})
        self.assertIn("ended by SIGSEGV", self.row("crash")["message"])
        self.assertIn("is not a valid bag", self.row("broken")["message"])
        self.assertIn("--memory", self.row("memory")["message"])
        self.assertIn("1 of 5 recordings mapped", text)
        self.assertEqual(len((self.out / "summary.csv").read_text().splitlines()), 6)
        page = (self.out / "index.html").read_text()
        self.assertIn('href="maps/good/report.html"', page)
        self.assertIn('href="maps/crash/log.txt"', page)
        self.assertEqual([path.name for path in (self.out / "maps").glob(".*")], [])

    def test_without_pidfd_as_in_the_python_of_noetic(self):
        for name in ("hang", "good"):
            self.log(name + ".clf")
        run = "import os, runpy, sys; del os.pidfd_open; del sys.argv[0]; " \
              "runpy.run_path(sys.argv[0], run_name='__main__')"
        batch = subprocess.run([sys.executable, "-c", run, BATCH, str(self.logs), "--output",
                                str(self.out), "--timeout", "1", "--memory", "1e300"],
                               capture_output=True, text=True, check=False, env=self.environment)
        self.assertEqual(batch.returncode, 1, batch.stderr)
        self.assertEqual([self.row(name)["status"] for name in ("good", "hang")], ["ok", "timeout"])

    def test_allowed_failures(self):
        self.log("broken.clf")
        self.log("good.clf")
        self.batch("--max-failed", "1")
        self.batch("--resume", "--max-failed", "0", code=3)

    def test_wrong_options_are_said_before_the_first_recording(self):
        self.log("good.clf")
        text = self.batch("--set", "nonsense=1", code=1)
        self.assertIn("unknown parameter 'nonsense'", text)
        self.assertFalse(self.out.exists())


class Terminal(Batch):
    def test_one_progress_bar_for_all(self):
        self.log("a.clf")
        self.log("b.clf")
        ours, theirs = pty.openpty()
        with subprocess.Popen([BATCH, str(self.logs), "--output", str(self.out), "-j", "1"],
                              env={**self.environment, "SLOW": "1"}, stderr=theirs,
                              stdout=subprocess.DEVNULL) as process:
            os.close(theirs)
            shown = b""
            try:
                while part := os.read(ours, 4096):
                    shown += part
            except OSError:  # a terminal that nobody has any more
                pass
        os.close(ours)
        self.assertEqual(process.returncode, 0)
        self.assertIn(b"[" + 12 * b"#" + 12 * b" " + b"] 1/2, 0:0", shown)


class Resume(Batch):
    def test_results_are_kept_and_missing_ones_are_mapped(self):
        self.log("a.clf")
        self.batch()
        self.log("b.clf")
        self.assertIn("--resume", self.batch(code=1))
        self.batch("--resume")
        self.assertEqual(self.called(), ["a.clf", "b.clf"])
        self.batch("--resume", "--set", "x=1")
        self.assertEqual(self.called(), ["a.clf", "a.clf", "b.clf", "b.clf"], "other parameters")
        self.log("a.clf", error_mm=11)
        self.batch("--resume", "--set", "x=1")
        self.assertEqual(len(self.called()), 5, "another input")

    def finished(self):
        return len(list((self.out / "maps").glob("[0-9]*")))

    def test_killed_twice_it_gives_the_same_table(self):
        for number in range(12):
            self.log(f"{number:02d}.clf", number)
        self.batch()
        expected = self.summary()
        table = (self.out / "summary.csv").read_bytes()
        self.out.rename(self.folder / "whole")
        self.calls.unlink()
        command = [BATCH, str(self.logs), "--output", str(self.out), "--no-timing", "-j", "2",
                   "--resume"]
        for _ in range(2):
            with subprocess.Popen(command, env={**self.environment, "SLOW": "0.3"},
                                  stderr=subprocess.DEVNULL) as process:
                before = self.finished()
                while self.finished() < before + 2 and process.poll() is None:
                    time.sleep(0.02)
                process.send_signal(signal.SIGKILL)
        done = self.finished()
        self.assertTrue(1 <= done < 12, done)
        self.batch("--resume")
        self.assertEqual(self.summary(), expected)
        self.assertEqual((self.out / "summary.csv").read_bytes(), table)
        self.assertLess(len(self.called()), 12 + 2 * 2 + 1, "only what was cut off is repeated")

    def test_an_interrupt_ends_the_programs(self):
        self.log("hang.clf")
        with subprocess.Popen([BATCH, str(self.logs), "--output", str(self.out)],
                              env=self.environment, stderr=subprocess.PIPE, text=True) as process:
            while not self.called():
                time.sleep(0.05)
            process.send_signal(signal.SIGINT)
            self.assertIn("--resume goes on", process.communicate(timeout=10)[1])
        self.assertEqual(process.returncode, 130)
        commands = [path.read_text(errors="replace") for path in
                    pathlib.Path("/proc").glob("[0-9]*/cmdline") if path.exists()]
        self.assertFalse([command for command in commands if str(self.logs) in command])


class Limits(Batch):
    def test_a_missed_limit_gives_exit_code_3(self):
        self.log("a.clf", 10)
        self.log("b.clf", 30)
        self.batch("--max-relations", "0.031")
        text = self.batch("--resume", "--max-relations", "0.02", code=3)
        self.assertIn("b: relations_m is 0.03, limit 0.02", text)
        self.assertIn("cannot be checked", self.batch("--resume", "--max-ate", "1", code=3))
        self.log("lost.clf")
        self.batch("--resume", "--max-lost", "0.5")
        self.batch("--resume", "--max-lost", "0.4", code=3)

    def test_an_error_that_is_not_known_misses_the_limit(self):
        self.log("a.clf", 10)
        self.log("b.clf", 999)
        self.log("none.clf", relations=False)
        self.batch()
        text = self.batch("--resume", "--max-relations", "0.031", code=3)
        self.assertIn("b: relations_m is not known", text)
        self.assertNotIn("none: relations_m", text)

    def test_limits_are_numbers(self):
        for option, value in (("--max-ate", "nan"), ("--memory", "inf"), ("--timeout", "inf"),
                              ("--max-failed", "-1"), ("--max-lost", "nan"), ("-j", "0")):
            self.assertIn(option, self.batch(option, value, code=2))


class Comparison(Batch):
    def test_worse_results_come_first(self):
        for name, error in (("same", 10), ("worse", 10), ("better", 10), ("fails", 10)):
            self.log(name + ".clf", error)
        self.batch()
        old = self.folder / "old"
        self.out.rename(old)
        self.log("worse.clf", 20)
        self.log("better.clf", 5)
        self.log("fails.clf", 5)
        (self.logs / "fails.clf").rename(self.logs / "brokenfails.clf")
        self.batch("--compare", str(old), code=1)
        comparison = self.summary()["comparison"]
        self.assertEqual([(change["name"], change["verdict"]) for change in comparison["changes"]],
                         [("worse", "worse"), ("same", "same"), ("better", "better")])
        self.assertEqual(comparison["changes"][0]["relations_m"], [0.01, 0.02])
        self.assertEqual((comparison["new"], comparison["gone"]), (["brokenfails"], ["fails"]))
        page = (self.out / "index.html").read_text()
        self.assertLess(page.index("0.0100 → 0.0200"), page.index("<h2>Recordings"))

    def test_an_error_that_is_gone_is_worse(self):
        self.log("a.clf")
        self.log("same.clf")
        self.batch()
        self.out.rename(self.folder / "old")
        self.log("a.clf", 999)
        text = self.batch("--compare", str(self.folder / "old"))
        self.assertIn("1 worse, 0 better", text)
        self.assertIn("a: no relations any more", text)


class Finding(Batch):
    def test_split_bags_are_one_recording(self):
        self.log("run_0.bag", text="100 160")
        self.log("run_1.bag", text="159.999 200")  # its first message waited for a thread
        self.log("run_2.bag", text="900 960")  # another flight: there is a pause
        self.log("r_2020-01-01-10-00-00_0.bag", text="100 160")
        self.log("r_2020-01-01-10-01-00_1.bag", text="160.1 200")
        self.log("many_9.bag", text="90 100")
        self.log("many_10.bag", text="100 110")
        self.batch()
        self.assertEqual(self.names(), ["many", "r", "run", "run_2"])

    def test_names_in_folders_are_unique(self):
        self.log("x/flight.clf")
        self.log("y/flight.clf")
        self.log("same.clf")
        self.log("same.bag", text="1 2")
        (self.logs / "notes.md").write_text("no recording")
        (self.logs / "damaged.bag").write_text("no bag")
        self.batch(code=1)
        self.assertEqual(self.names(), ["damaged", "same.bag", "same.clf", "x__flight",
                                        "y__flight"])
        self.assertEqual(self.row("damaged")["status"], "failed")

    def test_a_list_names_files_folders_and_parts(self):
        self.log("x/flight.clf")
        self.log("a.bag", text="1 2")
        self.log("b.bag", text="500 501")
        folder = self.logs
        self.logs = self.folder / "list"
        self.logs.write_text("# a comment\nlogs/x\nlogs/a.bag logs/b.bag\n")
        self.batch()
        self.assertEqual(len(self.names()), 2)
        self.logs.write_text("logs/missing.bag\n")
        self.out = self.folder / "other"
        self.assertIn(f"list:1: {folder}/missing.bag does not exist", self.batch(code=1))

    def test_a_file_that_ends_recording_info_hides_no_other(self):
        for name in ("a.clf", "kills_info.log", "z.clf"):
            self.log(name)
        self.batch()
        self.assertEqual(self.names(), ["a", "z"])

    def test_topics_of_a_list_are_asked_for_at_once(self):
        for name in "abcdefgh":
            self.log(f"topic_{name}.bag", text="1 2", relations=False)
        listing = self.folder / "list"
        listing.write_text("\n".join(map(str, sorted(self.logs.glob("*.bag")))))
        self.logs = listing
        self.batch()
        self.assertEqual({row["ate_m"] for row in self.summary()["recordings"]}, {0.01})
        self.assertLess(len(self.asked.read_text().splitlines()), 8)

    def test_ground_truth_by_rule(self):
        self.log("a.clf", relations=False)
        self.log("topic.bag", text="1 2", relations=False)
        (self.logs / "a.reference.tum").write_text("")
        self.batch()
        self.assertEqual(self.row("a")["ate_m"], 0.01)
        self.assertEqual(self.row("topic")["ate_m"], 0.01)
        (self.folder / "truth").mkdir()
        (self.folder / "truth" / "a.txt").write_text("")
        self.batch("--resume", "--truth", "reference:../truth/{name}.txt")
        self.assertEqual((self.row("a")["ate_m"], self.row("topic")["ate_m"]), (0.01, None))
        self.assertIn("a rule is relations:PATTERN", self.batch("--resume", "--truth", "x", code=1))
        text = self.batch("--resume", "--truth", "reference:{name}.txt", "--truth", "topic:/x", code=1)
        self.assertIn(f"by a file such as {self.logs}/a.txt or a topic /x", text)


class WaitingForSlurm(unittest.TestCase):
    def test_only_a_job_that_is_gone_is_at_its_end(self):
        answers = (("echo 7 test map_batch", True), ("true", False),
                   ("echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1", False),
                   ("echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1",
                    True))
        with tempfile.TemporaryDirectory() as folder:
            squeue = pathlib.Path(folder) / "squeue"
            for answer, queued in answers:
                squeue.write_text(f"#!/bin/sh\n{answer}\n")
                squeue.chmod(0o755)
                with unittest.mock.patch.dict(os.environ, PATH=f"{folder}:{os.environ['PATH']}"):
                    self.assertEqual(slurm.is_queued("7"), queued, answer)


if __name__ == "__main__":
    unittest.main()
