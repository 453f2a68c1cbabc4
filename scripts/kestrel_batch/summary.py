# SPDX-License-Identifier: BSD-3-Clause
"""The table of a batch, its comparison with an older one, and its limits."""

import csv
import io

from . import task
from .tools import read_json

# name in the table, where it is in stats.json or evaluation.json
STATS = (("scans", "scans", "processed"), ("lost_share", "match", "share_lost"),
         ("degraded_share", "match", "share_degraded"), ("distance_m", "distance_m"),
         ("duration_s", "duration_s"), ("area_m2", "map", "known_area_m2"),
         ("ms_per_scan", "timing", "ms_per_scan", "mean"),
         ("memory_mb", "timing", "peak_memory_mb"), ("processing_s", "timing", "processing_s"),
         ("commit", "commit"), ("version", "version"), ("input_hash", "recording", "hash"),
         ("parameters_hash", "parameters_hash"))
ERRORS = (("relations_m", "relations", "all", "translation_m", "mean"),
          ("distant_relations_m", "relations", "over_60_s", "translation_m", "mean"),
          ("ate_m", "reference", "ate", "translation_m", "rmse"),
          ("wrong_and_ok", "states", "wrong_and_ok"))
COLUMNS = ("name", "status", "relations_m", "distant_relations_m", "ate_m", "lost_share",
           "degraded_share", "dropped", "wrong_and_ok", "scans", "distance_m", "duration_s",
           "area_m2", "ms_per_scan", "processing_s", "memory_mb", "instructions_million",
           "warnings", "input_hash", "parameters_hash", "commit", "version", "message")

# A result counts as worse or better than the old one if its error differs by this share, or its
# share of lost scans by this much.
CLEAR_ERROR = 0.1
CLEAR_LOST = 0.01


def value_at(tree, path):
    for name in path:
        if not isinstance(tree, dict) or name not in tree:
            return None
        tree = tree[name]
    return tree


def row_of(plan, recording):
    """The line of one recording; missing values are None."""
    folder, result = task.folder_of(plan, recording), task.result_of(plan, recording)
    row = dict.fromkeys(COLUMNS)
    row["name"] = recording["name"]
    if result is None:
        return {**row, "status": "missing", "message": "was not mapped"}
    row.update(status=result["status"], message=result["message"],
               instructions_million=result.get("instructions_million"))
    if result["status"] != "ok":
        return row
    stats = read_json(folder / "stats.json") or {}
    for name, *path in STATS:
        row[name] = value_at(stats, path)
    row["dropped"] = sum((value_at(stats, ["scans", "dropped"]) or {}).values())
    row["warnings"] = len(stats.get("warnings", []))
    errors = read_json(folder / "evaluation.json") or {}
    for name, *path in ERRORS:
        if value_at(errors, [*path[:-1], "count"]) != 0:  # without items the mean is no result
            row[name] = value_at(errors, path)
    return row


def summarize(plan):
    """Everything that summary.json holds."""
    rows = [row_of(plan, recording) for recording in plan["recordings"]]
    summary = {"options": plan["options"], "limits": plan["limits"],
               "totals": totals_of(rows), "missed": missed_limits(plan, rows),
               "recordings": rows}
    if plan["compare"]:
        summary["comparison"] = compare(plan["compare"], rows)
    return summary


def totals_of(rows):
    mapped = [row for row in rows if row["status"] == "ok"]
    totals = {"recordings": len(rows), "mapped": len(mapped), "failed": len(rows) - len(mapped)}
    for name in ("scans", "distance_m", "duration_s", "processing_s"):
        values = [row[name] for row in mapped if row[name] is not None]
        totals[name] = round(sum(values), 3) if values else None
    for name in ("relations_m", "ate_m", "lost_share"):
        values = sorted(row[name] for row in mapped if row[name] is not None)
        if values:
            totals["median_" + name] = values[(len(values) - 1) // 2]
            totals["largest_" + name] = values[-1]
    return totals


# The error that a ground truth of this kind gives.
TRUTH = {"relations_m": "relations", "ate_m": "reference"}


def missed_limits(plan, rows):
    """One sentence for each limit and recording that misses it."""
    missed = []
    for name, limit in plan["limits"].items():
        if name == "failed" or limit is None:
            continue
        checked = [row for row in rows if row[name] is not None]
        unknown = [row["name"] for row, recording in zip(rows, plan["recordings"])
                   if row[name] is None and row["status"] == "ok"
                   and name in TRUTH and recording[TRUTH[name]]]
        missed += [f"{row_name}: {name} is not known, although there is a ground truth: the "
                   f"limit {limit:g} cannot be checked" for row_name in unknown]
        if not checked and not unknown:
            missed.append(f"{name}: the limit {limit:g} cannot be checked, because no recording "
                          "has this value")
        missed += [f"{row['name']}: {name} is {row[name]:g}, limit {limit:g}" for row in checked
                   if row[name] > limit]
    return missed


def exit_code(summary):
    """0: all recordings were mapped and no limit is missed; 1: some could not be mapped; 3: a limit
    is missed."""
    if summary["missed"]:
        return 3
    allowed = summary["limits"]["failed"]
    if summary["totals"]["failed"] <= (allowed or 0):
        return 0
    return 1 if allowed is None else 3


def compare(old_folder, rows):
    """What changed since an older batch: worse results first."""
    old = read_json(f"{old_folder}/summary.json") or {"recordings": []}
    by_name = {row["name"]: row for row in old["recordings"]}
    changes = [change_of(by_name[row["name"]], row) for row in rows if row["name"] in by_name]
    changes.sort(key=lambda change: (-change["badness"], change["name"]))
    names = {row["name"] for row in rows}
    return {"old": str(old_folder), "old_commits": commits_of(old["recordings"]),
            "commits": commits_of(rows),
            "worse": sum(change["verdict"] == "worse" for change in changes),
            "better": sum(change["verdict"] == "better" for change in changes),
            "new": sorted(names - set(by_name)), "gone": sorted(set(by_name) - names),
            "changes": changes}


def commits_of(rows):
    return sorted({row["commit"] for row in rows if row.get("commit")})


def change_of(old, new):
    """`badness`: 0 is equal; 0.1 is an error that is 10 % larger, or 1 % more of the scans lost."""
    change = {"name": new["name"], "other_input": differs(old, new, "input_hash"),
              "other_parameters": differs(old, new, "parameters_hash")}
    for name in ("relations_m", "ate_m", "lost_share", "ms_per_scan", "memory_mb",
                 "instructions_million"):
        change[name] = [old.get(name), new.get(name)]
    change["status"] = [old["status"], new["status"]]
    change["badness"] = round(badness_of(old, new), 4)
    change["verdict"] = "same"
    if not change["other_input"] and abs(change["badness"]) > CLEAR_ERROR:
        change["verdict"] = "worse" if change["badness"] > 0 else "better"
    return change


def differs(old, new, name):
    return None not in (old.get(name), new.get(name)) and old[name] != new[name]


def badness_of(old, new):
    failed = (new["status"] != "ok") - (old["status"] != "ok")
    if failed or new["status"] != "ok":
        return 1000.0 * failed
    if any(old.get(name) is not None and new[name] is None for name in TRUTH):
        return 100.0  # without its error, the result may be anything
    badness = next((new[name] / old[name] - 1.0 for name in TRUTH if old.get(name)), 0.0)
    lost = ((new["lost_share"] or 0.0) - (old["lost_share"] or 0.0)) * CLEAR_ERROR / CLEAR_LOST
    return max(badness, lost, key=abs)


def csv_of(rows):
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n", extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
