#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""map_batch --slurm on a cluster of one machine, with slurmctld, slurmd and munge on the loopback.

Ten recordings, one of which crashes; the node is killed and started again in between. Exit code 77
(skipped) where Slurm is not installed or this user cannot start it."""

import getpass
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import time
import unittest

from map_batch_test import BATCH, Batch

PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch", "squeue", "sinfo")
CONFIG = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ctld_port}
SlurmdPort={slurmd_port}
SlurmUser=root
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmdSpoolDir={folder}/slurmd
StateSaveLocation={folder}/state
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_min_interval=0,batch_sched_delay=0
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=1500 State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Slurm:
    """A cluster of this machine, in a folder."""

    def __init__(self, folder):
        self.folder = folder
        self._daemons = {}
        for name in ("slurmd", "state"):
            (folder / name).mkdir()
        folder.chmod(0o755)
        self.config = folder / "slurm.conf"
        self.config.write_text(CONFIG.format(folder=folder, host=socket.gethostname().split(".")[0],
                                             ctld_port=free_port(), slurmd_port=free_port()))
        self.environment = {**os.environ, "SLURM_CONF": str(self.config)}
        self._start_munge()
        self.start("slurmctld", "-D", "-f", str(self.config))
        self.start_node()

    def _start_munge(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        files = {name: self.folder / f"munge.{name}" for name in ("socket", "pid", "log", "seed")}
        self.start("munged", "--foreground", "--force", f"--key-file={key}",
                   f"--socket={files['socket']}", f"--pid-file={files['pid']}",
                   f"--log-file={files['log']}", f"--seed-file={files['seed']}")
        self.wait_for(files["socket"].exists)

    def start(self, name, *arguments):
        log = open(self.folder / f"{name}.out", "ab")  # the daemon keeps it
        self._daemons[name] = subprocess.Popen([shutil.which(name), *arguments], stdout=log,
                                               stderr=log, env=self.environment)

    def start_node(self):
        self.start("slurmd", "-D", "-f", str(self.config))
        self.wait_for(lambda: self.state() in ("idle", "mixed", "mix", "alloc", "allocated"))

    def kill_node(self):
        self._daemons["slurmd"].kill()
        self._daemons["slurmd"].wait()

    def state(self):
        run = subprocess.run(["sinfo", "--noheader", "--format=%T"], capture_output=True, text=True,
                             check=False, env=self.environment)
        return run.stdout.strip().rstrip("*")

    @staticmethod
    def wait_for(condition, seconds=30.0):
        begin = time.monotonic()
        while not condition():
            if time.monotonic() - begin > seconds:
                raise RuntimeError("Slurm did not start")
            time.sleep(0.1)

    def stop(self):
        subprocess.run(["scancel", "--user", getpass.getuser()], check=False, env=self.environment)
        for name in ("slurmd", "slurmctld", "munged"):
            self._daemons[name].terminate()
            self._daemons[name].wait()


def slowness():
    """How much longer work takes because of what else runs here."""
    begin, cpu = time.monotonic(), time.process_time()
    while time.process_time() - cpu < 0.3:
        pass
    return max(1.0, (time.monotonic() - begin) / 0.3)


class SlurmBatch(Batch):
    def setUp(self):
        super().setUp()
        (self.folder / "slurm").mkdir()
        self.slurm = Slurm(self.folder / "slurm")
        self.environment.update(self.slurm.environment, KESTREL_TOOLS=str(self.folder / "tools"),
                                CALLS=str(self.calls))

    def tearDown(self):
        self.slurm.stop()
        super().tearDown()

    def test_one_crashes_and_the_node_is_restarted(self):
        for number in range(9):
            self.log(f"{number}.clf", number)
        self.log("crash.clf")
        command = [BATCH, str(self.logs), "--output", str(self.out), "--no-timing", "--slurm",
                   "test", "--memory", "500", "-j", "2"]
        begin = time.monotonic()
        with subprocess.Popen(command, env={**self.environment, "SLOW": "1"}, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
            Slurm.wait_for(lambda: len(self.called()) >= 3)
            self.slurm.kill_node()
            time.sleep(1.0)
            self.slurm.start_node()
            text = process.communicate(timeout=150)[0]
        self.assertEqual(process.returncode, 1, text)
        self.assertIn("9 of 10 recordings mapped", text)
        self.assertIn("crash: crashed: ended by SIGSEGV", text)
        self.assertEqual(self.row("7")["relations_m"], 0.007)
        print(f"ten tasks of 1 s on two cores, with a restart: {time.monotonic() - begin:.0f} s",
              file=sys.stderr)
        submitted = json.loads((self.out / "slurm" / "tasks_0_0.json").read_text())
        self.assertEqual(len(submitted), 10)

    def test_overhead_of_a_task(self):
        for number in range(10):
            self.log(f"{number}.clf", number)
        before, begin = slowness(), time.monotonic()
        self.batch("--slurm", "--memory", "500", "-j", "2")
        seconds = time.monotonic() - begin
        busy = max(before, slowness())
        print(f"ten empty tasks: {seconds:.1f} s; the machine takes {busy:.1f} times as long as an "
              "idle one", file=sys.stderr)
        self.assertLess(seconds / 10 / busy, 1.0, "with starting and ending the batch")


if __name__ == "__main__":
    if os.getuid() != 0 or not all(map(shutil.which, PROGRAMS)):
        print("skipped: needs root, slurmctld, slurmd, munge and slurm-client")
        sys.exit(77)
    del Batch  # its tests are those of map_batch_test.py
    unittest.main()
