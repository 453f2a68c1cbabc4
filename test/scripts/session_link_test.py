#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""session_link between two hosts: two network namespaces with a bad connection between them.

A session grows on one host. The network is cut, and both programs are killed and started again.
At the end the other host has every keyframe once. Exit code 77 (skipped) where no network
namespaces can be made; loss and delay are left out where the kernel has no netem."""

import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

TOOLS = pathlib.Path(os.environ.get("KESTREL_TOOL_DIR", "."))
HOSTS = (f"kestrel_a{os.getpid()}", f"kestrel_b{os.getpid()}")
ADDRESS = "10.231.7.2"
WALLS = [(-6, -4, 6, -4), (6, -4, 6, 4), (6, 4, -6, 4), (-6, 4, -6, -4), (1, 1, 2, 1), (2, 1, 2, 2),
         (2, 2, 1, 2), (1, 2, 1, 1), (-4, -1, -3, -1), (-3, -1, -3, -3), (-1, 4, -1, 2.5)]


def ip(*arguments, check=True):
    return subprocess.run(("ip",) + arguments, check=check, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)


def distance(x, y, angle):
    nearest = 29.0
    dx, dy = math.cos(angle), math.sin(angle)
    for x0, y0, x1, y1 in WALLS:
        ex, ey = x1 - x0, y1 - y0
        det = ex * dy - ey * dx
        if abs(det) < 1e-12:
            continue
        along = (dx * (y0 - y) - dy * (x0 - x)) / det
        far = (ex * (y0 - y) - ey * (x0 - x)) / det
        if far > 0 and 0 <= along <= 1:
            nearest = min(nearest, far)
    return nearest


def write_log(path, scans):
    """A drive in a circle, as a CARMEN log."""
    with open(path, "w", encoding="ascii") as log:
        for i in range(scans):
            turn = 0.05 * i
            x, y, yaw = 2.5 * math.sin(turn), -2.5 * math.cos(turn), turn
            ranges = [distance(x, y, yaw + math.radians(k - 90)) for k in range(181)]
            text = " ".join(f"{r:.3f}" for r in ranges)
            pose = f"{x:.4f} {y:.4f} {yaw:.5f}"
            log.write(f"FLASER 181 {text} {pose} {pose} {0.2 * i:.3f} host {0.2 * i:.3f}\n")


class SessionLink(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="session_link_"))
        self.running = []
        a, b = HOSTS
        for host in HOSTS:
            ip("netns", "add", host)
        ip("link", "add", "veth_k", "netns", a, "type", "veth", "peer", "name", "veth_k", "netns", b)
        for host, address in ((a, "10.231.7.1"), (b, ADDRESS)):
            ip("-n", host, "addr", "add", address + "/24", "dev", "veth_k")
            ip("-n", host, "link", "set", "veth_k", "up")
            netem = ("ip", "netns", "exec", host, "tc", "qdisc", "add", "dev", "veth_k", "root",
                     "netem", "loss", "5%", "delay", "100ms")
            if subprocess.run(netem, stderr=subprocess.DEVNULL, check=False).returncode != 0:
                print("no netem in this kernel: without loss and delay", file=sys.stderr)

    def tearDown(self):
        for process in self.running:
            process.kill()
            process.wait()
        for host in HOSTS:
            ip("netns", "del", host, check=False)
        shutil.rmtree(self.folder, ignore_errors=True)

    def start(self, host, *arguments):
        command = ("ip", "netns", "exec", host, str(TOOLS / "session_link"), "--keys",
                   str(self.folder / "keys")) + arguments
        process = subprocess.Popen(command, start_new_session=True)
        self.running.append(process)
        return process

    def sender(self):
        return self.start(HOSTS[0], "--send", str(self.folder / "uav0.session"), "--connect",
                          f"tcp://{ADDRESS}:5601", "--journal", str(self.folder / "a"))

    def receiver(self):
        return self.start(HOSTS[1], "--receive", str(self.folder / "in"), "--listen",
                          "tcp://*:5601", "--journal", str(self.folder / "b"))

    def kill(self, process):
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def save(self, scans):
        """The session after so many scans, as a mapper saves it."""
        out = self.folder / f"map_{scans}"
        subprocess.run((str(TOOLS / "map_recording"), str(self.folder / "drive.clf"), "--output",
                        str(out), "--loops", "use", "--scans", str(scans), "--quiet",
                        "--save-session", str(self.folder / "new")), check=True)
        os.replace(self.folder / "new", self.folder / "uav0.session")

    def keyframes(self, path):
        shown = subprocess.run((str(TOOLS / "session_info"), str(path)), stdout=subprocess.PIPE,
                               stderr=subprocess.DEVNULL, text=True, check=False).stdout
        for line in shown.splitlines():
            if line.startswith("keyframes"):
                return int(line.split()[1])
        return 0

    def wait_until_complete(self, seconds):
        wanted = self.keyframes(self.folder / "uav0.session")
        for _ in range(2 * seconds):  # not the clock: it jumps where the machine stands still
            if self.keyframes(self.folder / "in" / "uav0.session") == wanted:
                return
            time.sleep(0.5)
        self.assertEqual(self.keyframes(self.folder / "in" / "uav0.session"), wanted)

    def test_everything_arrives_after_partition_and_restarts(self):
        subprocess.run((str(TOOLS / "session_link"), "--make-keys", str(self.folder / "keys")),
                       check=True)
        write_log(self.folder / "drive.clf", 240)
        self.save(60)
        sender, receiver = self.sender(), self.receiver()
        self.wait_until_complete(20)
        ip("-n", HOSTS[0], "link", "set", "veth_k", "down")
        self.save(120)
        time.sleep(10)
        ip("-n", HOSTS[0], "link", "set", "veth_k", "up")
        self.wait_until_complete(20)
        self.kill(receiver)
        self.save(180)
        time.sleep(3)
        self.kill(sender)
        self.receiver()
        self.save(240)
        self.sender()
        self.wait_until_complete(20)


def main():
    probe = f"kestrel_p{os.getpid()}"
    if shutil.which("ip") is None or ip("netns", "add", probe, check=False).returncode != 0:
        print("skipped: this user cannot make network namespaces")
        return 77
    ip("netns", "del", probe)
    return 0 if unittest.main(exit=False).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
