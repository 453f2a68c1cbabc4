# SPDX-License-Identifier: BSD-3-Clause
"""Stand-ins for the programs that map_batch starts: they fail by the name of the recording."""

# Writes the files of a mapped recording; the first word of the recording is its error in mm.
MAP_RECORDING = r"""#!/usr/bin/python3
import base64, json, os, signal, sys, time
if "--list-parameters" in sys.argv:
    sys.exit("map_recording: unknown parameter 'nonsense'" if "nonsense=1" in sys.argv else 0)
output, file = sys.argv[sys.argv.index("--output") + 1], sys.argv[-1]
name = os.path.basename(file)
with open(os.environ["CALLS"], "a") as calls:
    calls.write(name + "\n")
if name.startswith("crash"):
    os.kill(os.getpid(), signal.SIGSEGV)
if name.startswith("hang"):
    time.sleep(600)
if name.startswith("memory"):
    try:
        bytearray(1 << 31)
    except MemoryError:
        sys.exit("map_recording: std::bad_alloc")
if name.startswith("broken"):
    sys.exit("map_recording: " + file + ": is not a valid bag")
time.sleep(float(os.environ.get("SLOW", "0")))
error = float(open(file).readline()) / 1000.0
os.makedirs(output)
for part in ("map.pgm", "report.html", "trajectory.tum", "scans.csv"):
    open(output + "/" + part, "w").write(str(error))
open(output + "/thumbnail.png", "wb").write(base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg=="))
json.dump({"version": "1", "commit": "c0ffee", "parameters_hash": "p",
           "recording": {"hash": name}, "distance_m": 2.0, "duration_s": 3.0,
           "scans": {"processed": 10, "dropped": {"late": 1}}, "warnings": [],
           "match": {"share_lost": 0.5 if name.startswith("lost") else 0.0,
                     "share_degraded": 0.0}, "map": {"known_area_m2": 1.0}},
          open(output + "/stats.json", "w"))
"""
EVALUATE = r"""#!/usr/bin/python3
import json, sys
error = float(open(sys.argv[1]).read())
if error > 0.9:
    sys.exit("evaluate_trajectory: nothing to compare")
statistics = {"translation_m": {"mean": error, "rmse": error}}
answer = {}
if "--relations" in sys.argv:
    answer["relations"] = {"all": statistics, "over_60_s": statistics}
if "--reference" in sys.argv:
    answer["reference"] = {"ate": statistics}
json.dump(answer, open(sys.argv[sys.argv.index("--json") + 1], "w"))
"""
# Every file that begins with a number is a recording. Bags have their times in the second line.
RECORDING_INFO = r"""#!/usr/bin/python3
import json, os, sys
open(os.environ["ASKED"], "a").write("asked\n")
for path in sys.argv[sys.argv.index("--") + 1:]:
    if "kills_info" in path:
        os.kill(os.getpid(), 11)
    lines = open(path, errors="replace").read().split("\n")
    number = lines[0].replace(".", "").isdigit()
    bag = path.endswith(".bag") and number
    begin, end = map(float, lines[1].split()) if bag and len(lines) > 1 and lines[1] else (0, 0)
    topics = {"/ground_truth": {"type": "nav_msgs/Odometry", "messages": 9}} if "topic" in path else {}
    print(json.dumps({"path": path, "format": "rosbag" if bag else "CARMEN log" if number else "",
                      "begin_s": begin, "end_s": end, "topics": topics, "problem": ""}))
"""
