#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The clients of scripts/soak.

soak_client.py fly SECONDS NODELETS: publishes the flight, measures, prints a line per period and
the verdict. The exit code is 1 if the verdict is bad.
soak_client.py slow: subscribes to the large topics and takes 5 s for every message.
soak_client.py garbage: publishes messages that nobody can use.
"""

import math
import os
import random
import statistics
import sys
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import Imu, LaserScan, PointCloud2, Range
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from kestrel_slam.msg import MapperState
from kestrel_slam.srv import SaveMap

SCAN_HZ, IMU_HZ, BEAMS = 40, 100, 1081
LAP = 20.0  # s for one circle of 1 m radius in a room of 8 m x 6 m
HALF_X, HALF_Y, PILLAR = 4.0, 3.0, (2.5, 1.5, 0.4)
START, SETTLE = 10.0, 5.0  # s: until the nodes are up; scans that may be missed at the start
SAVE_EVERY, RESET_EVERY = 7.0, 20.0  # s
ALLOWED_GROWTH_MB = 4.0  # of the largest memory of the last third over that of the second


def pose_at(t):
    angle = 2 * math.pi * t / LAP
    return math.cos(angle) - 1.0, math.sin(angle), angle + math.pi / 2


def distance(x, y, dx, dy):
    """From (x, y) along the unit vector (dx, dy) to the wall or the pillar."""
    reach = min(((HALF_X if dx > 0 else -HALF_X) - x) / dx if dx else math.inf,
                ((HALF_Y if dy > 0 else -HALF_Y) - y) / dy if dy else math.inf)
    px, py = PILLAR[0] - x, PILLAR[1] - y
    along, square = px * dx + py * dy, px * px + py * py
    miss = square - along * along
    if along > 0 and miss < PILLAR[2] ** 2:
        reach = min(reach, along - math.sqrt(PILLAR[2] ** 2 - miss))
    return reach


def ranges_at(t, noise):
    x, y, yaw = pose_at(t)
    result = []
    for i in range(BEAMS):
        angle = yaw + math.radians(-135.0 + 0.25 * i)
        result.append(distance(x, y, math.cos(angle), math.sin(angle)) + noise.gauss(0.0, 0.01))
    return result


class Memory:
    """Resident memory of the processes under test, in MB."""

    def __init__(self, names):
        self.pids = {}
        master = rosgraph.Master(rospy.get_name())
        for name in names:
            node = xmlrpc.client.ServerProxy(master.lookupNode(name))
            self.pids[name] = node.getPid(rospy.get_name())[2]

    def now(self):
        """None if a process has ended."""
        try:
            return [self._of(pid) for pid in self.pids.values()]
        except (OSError, StopIteration):
            return None

    @staticmethod
    def _of(pid):
        with open(f"/proc/{pid}/status", encoding="ascii") as status:
            return next(int(line.split()[1]) / 1024 for line in status
                        if line.startswith("VmRSS:"))


class Flight:
    def __init__(self, seconds, nodelets):
        self.seconds = seconds
        self.names = ["/kestrel_manager"] if nodelets else ["/projector", "/mapper", "/pose_filter"]
        self.noise = random.Random(1)
        self.lap = [ranges_at(i / SCAN_HZ, self.noise) for i in range(int(LAP * SCAN_HZ))]
        self.scans = rospy.Publisher("scan", LaserScan, queue_size=100)
        self.imu = rospy.Publisher("imu/data", Imu, queue_size=100)
        self.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        self.sent, self.late, self.lock = {}, [], threading.Lock()
        self.problems, self.saves, self.resets, self.memory_log = [], 0, 0, []
        self.published, self.lost = 0, 0
        rospy.Subscriber("mapper_state", MapperState, self.on_state, queue_size=1000)

    def on_state(self, message):
        now = time.monotonic()
        with self.lock:
            sent = self.sent.pop(message.header.stamp.to_nsec(), None)
            if sent is not None:
                self.lost += message.state == MapperState.LOST
                self.late.append(1000.0 * (now - sent))

    def publish_mountings(self):
        transforms = []
        for child in ("laser", "imu"):
            transform = TransformStamped()
            transform.header.frame_id, transform.child_frame_id = "base_link", child
            transform.transform.rotation.w = 1.0
            transforms.append(transform)
        self.static.publish(TFMessage(transforms))

    def publish_imu(self, t):
        message = Imu()
        message.header.stamp, message.header.frame_id = rospy.Time.now(), "imu"
        yaw = pose_at(t)[2]
        message.orientation.z, message.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        rate = 2 * math.pi / LAP
        message.angular_velocity.z = rate + self.noise.gauss(0, 0.002)
        message.linear_acceleration.x = self.noise.gauss(0, 0.02)
        message.linear_acceleration.y = rate * rate + self.noise.gauss(0, 0.02)
        message.linear_acceleration.z = 9.80665 + self.noise.gauss(0, 0.02)
        self.imu.publish(message)

    def publish_scan(self, t):
        message = LaserScan()
        message.header.stamp, message.header.frame_id = rospy.Time.now(), "laser"
        message.angle_min, message.angle_max = math.radians(-135), math.radians(135)
        message.angle_increment = math.radians(0.25)
        message.range_min, message.range_max = 0.1, 30.0
        message.ranges = self.lap[int(round(t * SCAN_HZ)) % len(self.lap)]
        self.published += 1
        with self.lock:
            if t > SETTLE:
                self.sent[message.header.stamp.to_nsec()] = time.monotonic()
        self.scans.publish(message)

    def fly(self):
        begin, step = time.monotonic(), 1.0 / (SCAN_HZ * 5)  # 200 Hz: both rates fit
        count = 0
        while count * step < self.seconds and not rospy.is_shutdown():
            t = count * step
            if count % (200 // IMU_HZ) == 0:
                self.publish_imu(t)
            if count % (200 // SCAN_HZ) == 0:
                self.publish_scan(t)
            count += 1
            time.sleep(max(0.0, begin + count * step - time.monotonic()))

    def serve(self, ended):
        save, reset = rospy.ServiceProxy("save_map", SaveMap), rospy.ServiceProxy("reset_map", Trigger)
        next_save, next_reset = time.monotonic() + SAVE_EVERY, time.monotonic() + RESET_EVERY
        while not ended.wait(0.5):
            try:
                if time.monotonic() >= next_save:
                    next_save += SAVE_EVERY
                    self.check_saved(save(path="soak"))
                if time.monotonic() >= next_reset:
                    next_reset += RESET_EVERY
                    self.resets += 1
                    if not reset().success:
                        self.problems.append("reset_map did not succeed")
            except rospy.ServiceException as error:
                self.problems.append(f"a service failed: {error}")

    def check_saved(self, answer):
        self.saves += 1
        paths = [word.rstrip(",;.") for word in answer.message.split()]
        yaml = next((path for path in paths if path.endswith(".yaml")), None)
        if not answer.success or yaml is None or not os.path.exists(yaml):
            self.problems.append(f"save_map: {answer.message}")
            return
        with open(yaml, encoding="utf-8") as file:
            image = file.readline().split(":", 1)[1].strip().strip('"')
        with open(os.path.join(os.path.dirname(yaml), image), "rb") as file:
            if file.read(2) != b"P5":
                self.problems.append(f"{yaml} names no image")

    def report(self, memory, begin):
        with self.lock:
            late, self.late = self.late, []
            waiting = sum(1 for sent in self.sent.values() if sent < time.monotonic() - 1.0)
        now = memory.now()
        if now is None:
            self.problems.append("a process ended")
            return
        self.memory_log.append(sum(now))
        seconds = int(time.monotonic() - begin)
        latency = (f"latency {statistics.median(late):.1f} ms median, {max(late):.1f} ms max"
                   if late else "no poses")
        print(f"{seconds // 60:4d}:{seconds % 60:02d}  "
              f"{' + '.join(f'{mb:.1f}' for mb in now)} MB  {self.published} scans, {waiting} "
              f"without a pose, {self.lost} lost  {latency}  {self.saves} saves, {self.resets} resets", flush=True)

    def verdict(self):
        missing = len(self.sent)
        third = len(self.memory_log) // 3
        if third > 0:
            before = max(self.memory_log[third:2 * third])
            growth = max(self.memory_log[2 * third:]) - before
            if growth > ALLOWED_GROWTH_MB:
                self.problems.append(f"the memory grew by {growth:.1f} MB")
        if missing > 0:
            self.problems.append(f"{missing} of {self.published} scans gave no pose")
        if self.lost > 0:
            self.problems.append(f"the pose was lost in {self.lost} of {self.published} scans")
        for problem in dict.fromkeys(self.problems):
            print(f"problem: {problem}")
        print("verdict: bad" if self.problems else "verdict: good", flush=True)
        return 1 if self.problems else 0

    def run(self):
        self.publish_mountings()
        for service in ("save_map", "reset_map"):
            rospy.wait_for_service(service, START)
        time.sleep(1.0)
        memory, ended, begin = Memory(self.names), threading.Event(), time.monotonic()
        threads = [threading.Thread(target=self.fly),
                   threading.Thread(target=self.serve, args=(ended,))]
        for thread in threads:
            thread.start()
        period = 10.0 if self.seconds <= 600 else 60.0
        while threads[0].is_alive() and "a process ended" not in self.problems:
            threads[0].join(period)
            self.report(memory, begin)
        time.sleep(2.0)
        ended.set()
        if "a process ended" in self.problems:
            rospy.signal_shutdown("a process ended")
        for thread in threads:
            thread.join()
        return self.verdict()


def be_slow():
    rospy.init_node("soak_slow")
    for topic, kind in (("map", OccupancyGrid), ("trajectory", Path), ("slam_cloud", PointCloud2),
                        ("scan", LaserScan)):
        rospy.Subscriber(topic, kind, lambda message: time.sleep(5.0), queue_size=1)
    rospy.spin()


def garbage_scan(dice):
    message = LaserScan()
    message.header.stamp = rospy.Time(dice.choice([0, 1, 2 ** 31, 2 ** 32 - 1, int(time.time())]))
    message.header.frame_id = dice.choice(["", "nowhere", "frame_%d" % dice.randrange(10 ** 6)])
    message.angle_increment = dice.choice([0.0, math.nan, 1e-9, 0.01])
    message.range_max = dice.choice([0.0, math.inf, -1.0, 30.0])
    message.ranges = [dice.choice([math.nan, math.inf, -1.0, 1e30, 0.0])] * dice.choice([0, 1, 500])
    return message


def garbage_imu(dice):
    message = Imu()
    message.header.stamp = rospy.Time(dice.choice([0, 2 ** 31, 2 ** 32 - 1]))
    message.header.frame_id = "nowhere"
    message.angular_velocity.x = dice.choice([math.nan, 1e30])
    return message


def garbage_pose(dice):
    message = PoseWithCovarianceStamped()
    message.header.frame_id = "map"
    message.pose.pose.position.x = dice.choice([math.nan, math.inf, 1e30])
    return message


def send_garbage():
    rospy.init_node("soak_garbage")
    dice = random.Random(2)
    topics = [(rospy.Publisher("scan", LaserScan, queue_size=1), garbage_scan),
              (rospy.Publisher("imu/data", Imu, queue_size=1), garbage_imu),
              (rospy.Publisher("height", Range, queue_size=1), lambda dice: Range()),
              (rospy.Publisher("initialpose", PoseWithCovarianceStamped, queue_size=1),
               garbage_pose)]
    time.sleep(START)
    while not rospy.is_shutdown():
        publisher, message = dice.choice(topics)
        publisher.publish(message(dice))
        time.sleep(0.2)


def main():
    role = sys.argv[1] if len(sys.argv) > 1 else ""
    if role == "fly" and len(sys.argv) == 4:
        rospy.init_node("soak", disable_signals=True)
        flight = Flight(float(sys.argv[2]), sys.argv[3] == "true")
        sys.exit(flight.run())
    if role == "slow":
        be_slow()
    elif role == "garbage":
        send_garbage()
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
