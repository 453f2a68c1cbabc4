# SPDX-License-Identifier: BSD-3-Clause
"""The hosts of benchmark_fleet, which are network namespaces, and the bad radio between them."""

import ctypes
import fcntl
import heapq
import os
import random
import select
import socket
import struct
import subprocess
import threading
import time

VEHICLES = ("uav0", "uav1", "uav2")
LOSS, DELAY = 0.05, 0.2  # share of the packets; s
TUN, CLONE_NEWNET = 0x400454CA, 0x40000000


def host_of(vehicle):
    return f"kestrel_{vehicle}"


def address_of(vehicle):
    return f"10.231.7.{VEHICLES.index(vehicle) + 1}"


def run(*command, check=True):
    return subprocess.run(command, check=check, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)


class Radio(threading.Thread):
    """Passes IP packets between the hosts, as a bad radio does."""

    def __init__(self):
        super().__init__(daemon=True)
        self.devices, self.sent = {}, dict.fromkeys(VEHICLES, 0)
        self.cut_off, self.ended = set(), False
        self.random = random.Random(1)
        for vehicle in VEHICLES:
            run("ip", "netns", "add", host_of(vehicle))
            run("ip", "-n", host_of(vehicle), "link", "set", "lo", "up")
            self.devices[vehicle] = self.open_device(host_of(vehicle))
            for change in (("addr", "add", address_of(vehicle) + "/24", "dev", "radio"),
                           ("link", "set", "radio", "up")):
                run("ip", "-n", host_of(vehicle), *change)

    @staticmethod
    def open_device(host):
        libc = ctypes.CDLL(None, use_errno=True)
        with open("/proc/self/ns/net", "rb") as here, open(f"/run/netns/{host}", "rb") as there:
            if libc.setns(there.fileno(), CLONE_NEWNET) != 0:
                raise OSError(ctypes.get_errno(), "setns")
            device = os.open("/dev/net/tun", os.O_RDWR)
            fcntl.ioctl(device, TUN, struct.pack("16sH", b"radio", 0x0001 | 0x1000))
            libc.setns(here.fileno(), CLONE_NEWNET)
        return device

    def run(self):
        waiting, number = [], 0
        receivers = {socket.inet_aton(address_of(v)): v for v in VEHICLES}
        while not self.ended:
            ready = select.select(list(self.devices.values()), [], [], 0.005)[0]
            for sender, device in self.devices.items():
                if device not in ready:
                    continue
                packet = os.read(device, 65536)
                receiver = receivers.get(packet[16:20])
                if packet[0] >> 4 != 4 or receiver is None:
                    continue
                self.sent[sender] += len(packet)
                if {sender, receiver} & self.cut_off or self.random.random() < LOSS:
                    continue
                number += 1
                heapq.heappush(waiting, (time.monotonic() + DELAY, number, receiver, packet))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, receiver, packet = heapq.heappop(waiting)
                if receiver not in self.cut_off:
                    os.write(self.devices[receiver], packet)

    def close(self):
        self.ended = True
        for vehicle in VEHICLES:
            run("ip", "netns", "del", host_of(vehicle), check=False)
