#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""newcomer_test.py [--bare]: goes through the quick starts of README.md as a newcomer: copies the
lines of its code blocks into a terminal, and looks for map and report.

Uses the build of this clone (scripts/build). With --bare it clones the repository, and begins with
the lines of "Install". Windows appear on a virtual screen; without Xvfb and rviz, `rviz:=true` is
left out."""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
HAS_SCREEN = bool(shutil.which("Xvfb") and shutil.which("rviz"))
PATIENCE = 120  # s; for a map


def blocks():
    """The lines of the code blocks of README.md by the heading above them, without comments."""
    found, heading, inside = {}, "", False
    for line in (ROOT / "README.md").read_text().splitlines():
        if line.startswith("```"):
            inside = not inside
        elif inside:
            command = re.sub(r"\s{2,}#.*$", "", line).strip()
            found.setdefault(heading, []).append(command)
        elif line.startswith("#"):
            heading = line.lstrip("# ").strip()
    return found


def free_port():
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return any_port.getsockname()[1]


class Newcomer:
    """A user with a folder, a ROS master port and a screen of his own."""

    def __init__(self, folder):
        self.folder, self.running = folder, []
        self.env = dict(os.environ, ROS_IP="127.0.0.1", ROS_HOME=str(folder / "ros_home"),
                        ROS_MASTER_URI="http://127.0.0.1:%d" % free_port())
        if HAS_SCREEN:
            self.start_screen()

    def start_screen(self):
        read, write = os.pipe()
        screen = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24"],
                                  pass_fds=[write], stderr=subprocess.DEVNULL,
                                  start_new_session=True)
        os.close(write)
        self.running.append(screen)
        number = os.read(read, 16).decode().strip()
        os.close(read)
        self.env.update(DISPLAY=":" + number, LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1",
                        XDG_RUNTIME_DIR=str(self.folder))

    def typed(self, line):
        if HAS_SCREEN or "roslaunch" not in line:
            return line
        return line.replace(" rviz:=true", "") + " rviz:=false"

    def start(self, line):
        """A line in a terminal of its own."""
        print("$ " + self.typed(line), flush=True)
        log = open(self.folder / "terminals.log", "a")
        terminal = subprocess.Popen(["bash", "-c", self.typed(line)], cwd=self.folder, env=self.env,
                                    stdout=log, stderr=log, start_new_session=True)
        self.running.append(terminal)
        return terminal

    def run(self, line, seconds=600):
        code = self.start(line).wait(seconds)
        check(code == 0, "%s ended with exit code %d" % (line, code))

    def stop(self, terminal):
        """Ctrl-C."""
        self.running.remove(terminal)
        try:
            os.killpg(terminal.pid, signal.SIGINT)
            terminal.wait(20)
        except subprocess.TimeoutExpired:
            os.killpg(terminal.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def leave(self):
        for terminal in self.running[::-1]:
            self.stop(terminal)

    def sees(self, topic, pattern):
        """Whether a message on the topic matches within PATIENCE."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            echo = subprocess.run(
                ["bash", "-c", "timeout 15 scripts/run rostopic echo -n 1 " + topic],
                cwd=self.folder, env=self.env, capture_output=True, text=True, check=False)
            if re.search(pattern, echo.stdout):
                return True
            time.sleep(0.5)
        return False


def check(condition, problem):
    if condition:
        return
    raise AssertionError(problem)


def recorded_bag(user, lines):
    for line in lines:
        user.run(line)
    for name in ("report.html", "map.pgm", "map.yaml", "trajectory.tum", "stats.json"):
        check((user.folder / "out/flight" / name).stat().st_size > 0, "no " + name)


def whole_system(user, lines):
    demo = user.start(lines[0])
    check(user.sees("/map_metadata", r"width: [1-9]"), "demo.launch publishes no map")
    check(user.sees("/mapper_state", r"state: [01]\b"), "the mapper has no state")
    user.stop(demo)


def live_laser(user, launch, save):
    """The laser is that of the recorded flight."""
    saved = pathlib.Path(re.search(r"path: '([^']+)'", save[0]).group(1) + ".pgm")
    before = saved.stat().st_mtime if saved.exists() else 0.0
    mapping = user.start(launch[0])
    laser = user.start("sleep 5; scripts/run rosbag play -q --topics /scan -- flight.bag")
    check(user.sees("/map_metadata", r"width: [1-9]"), "mapper.launch publishes no map")
    user.run(save[0])
    check(saved.exists() and saved.stat().st_mtime > before, "save_map wrote no " + str(saved))
    if before == 0.0:
        saved.unlink()
        saved.with_suffix(".yaml").unlink()
    user.stop(laser)
    user.stop(mapping)


def replay_with_imu(user, lines):
    replay = user.start(lines[0])
    check(user.sees("/map_metadata", r"width: [1-9]"), "replay.launch publishes no map")
    check(user.sees("/odom/filtered", "position"), "the pose filter publishes nothing")
    user.stop(replay)


def look_like_a_clone(folder):
    """Links to everything in this clone: what the user writes stays in his folder."""
    for entry in ROOT.iterdir():
        if entry.name not in ("out", "flight.bag"):
            (folder / entry.name).symlink_to(entry)


def main():
    bare = sys.argv[1:] == ["--bare"]
    readme = blocks()
    live = readme["A live laser that stays level"]
    imu = readme["Flying with an IMU"]
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "kestrel_slam"
        if bare:
            subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True)
        else:
            folder.mkdir()
            look_like_a_clone(folder)
        user = Newcomer(folder)
        try:
            if bare:
                for line in [l for l in readme["Install"] if l.startswith("scripts/")]:
                    user.run(line, 3600)
                check((folder / "out/demo/report.html").exists(), "scripts/demo wrote no report")
            recorded_bag(user, readme["A recorded bag"])
            whole_system(user, readme["The whole system, without a robot"])
            live_laser(user, live[:1], live[1:])
            replay_with_imu(user, imu[-1:])
        except (AssertionError, OSError, subprocess.TimeoutExpired) as problem:
            print("FAILED: %s. The end of the terminals:" % problem)
            print((folder / "terminals.log").read_text(errors="replace")[-4000:])
            sys.exit(1)
        finally:
            user.leave()
    print("the quick starts of README.md work" + ("" if HAS_SCREEN else " (without rviz)"))


if __name__ == "__main__":
    main()
