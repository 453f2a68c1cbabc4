# SPDX-License-Identifier: BSD-3-Clause
"""Writes summary.csv, summary.json and index.html, and prints what matters of them."""

import html
import pathlib

from . import summary
from .tools import write_file, write_json

PAGE = (pathlib.Path(__file__).parent / "index.html").read_text(encoding="utf-8")
# name in the table, its title, its unit and decimals
SHOWN = (("relations_m", "relations", "m", 4), ("distant_relations_m", "> 60 s", "m", 4),
         ("ate_m", "ATE", "m", 4), ("lost_share", "lost", "%", 2),
         ("degraded_share", "degraded", "%", 1), ("dropped", "dropped", "", 0),
         ("wrong_and_ok", "wrong, but ok", "", 0), ("scans", "scans", "", 0),
         ("distance_m", "distance", "m", 1), ("duration_s", "duration", "s", 0),
         ("ms_per_scan", "time per scan", "ms", 3), ("memory_mb", "memory", "MB", 0),
         ("instructions_million", "instructions", "million", 1), ("warnings", "warnings", "", 0))
CHANGED = (("relations_m", "relations", "m", 4), ("ate_m", "ATE", "m", 4),
           ("lost_share", "lost", "%", 2), ("ms_per_scan", "time per scan", "ms", 3),
           ("memory_mb", "memory", "MB", 0), ("instructions_million", "instructions", "million", 1))
MOST_LINES = 10  # printed of each kind


def write_and_print(plan):
    """Returns the exit code of the batch."""
    result = summary.summarize(plan)
    folder = pathlib.Path(plan["output"])
    write_file(folder / "summary.csv", summary.csv_of(result["recordings"]))
    write_json(folder / "summary.json", result)
    write_file(folder / "index.html", page_of(result))
    print_result(folder, result)
    return summary.exit_code(result)


def print_result(folder, result):
    totals = result["totals"]
    print(f"{totals['mapped']} of {totals['recordings']} recordings mapped")
    failed = [row for row in result["recordings"] if row["status"] != "ok"]
    print_some("failed", [f"{row['name']}: {row['status']}: {row['message']}" for row in failed])
    for name, title, unit in (("relations_m", "relations", "m"), ("ate_m", "ATE", "m"),
                              ("lost_share", "lost scans, share", "")):
        if f"median_{name}" in totals:
            print(f"{title}: median {totals['median_' + name]:.4f} {unit}".rstrip() +
                  f", largest {totals['largest_' + name]:.4f} {unit}".rstrip())
    if "comparison" in result:
        print_comparison(result["comparison"])
    print_some("limit missed", result["missed"])
    print(f"table {folder / 'index.html'}, {folder / 'summary.csv'}, {folder / 'summary.json'}")


def print_comparison(comparison):
    print(f"against {comparison['old']}: {comparison['worse']} worse, "
          f"{comparison['better']} better, {len(comparison['changes'])} compared")
    print_some("worse", [sentence_of(change) for change in comparison["changes"]
                         if change["verdict"] == "worse"])


def sentence_of(change):
    parts = [f"{title} {cell(change[name][0], unit, decimals)} -> "
             f"{cell(change[name][1], unit, decimals)} {unit}".rstrip()
             for name, title, unit, decimals in CHANGED
             if change[name][0] != change[name][1] and None not in change[name]]
    parts += [f"no {title} any more" for name, title, _, _ in CHANGED
              if name in summary.TRUTH and None not in change["status"]
              and change[name][0] is not None and change[name][1] is None
              and change["status"][1] == "ok"]
    if change["status"][0] != change["status"][1]:
        parts.insert(0, " -> ".join(change["status"]))
    return f"{change['name']}: {', '.join(parts)}"


def print_some(title, lines):
    for line in lines[:MOST_LINES]:
        print(f"{title}: {line}")
    if len(lines) > MOST_LINES:
        print(f"{title}: {len(lines) - MOST_LINES} more, see summary.csv")


def cell(value, unit, decimals):
    if value is None:
        return ""
    return f"{value * 100.0 if unit == '%' else value:.{decimals}f}"


def page_of(result):
    rows = result["recordings"]
    shown = [column for column in SHOWN if any(row[column[0]] is not None for row in rows)]
    return (PAGE.replace("<!--headlines-->", headlines_of(result))
            .replace("<!--limits-->", items_of("Limits that are missed", result["missed"]))
            .replace("<!--comparison-->", comparison_of(result.get("comparison")))
            .replace("<!--head-->", head_of(["map", "recording", "status", *map(title_of, shown)]))
            .replace("<!--rows-->", "\n".join(line_of(row, shown) for row in rows)))


def title_of(column):
    return f"{column[1]}, {column[2]}" if column[2] else column[1]


def headlines_of(result):
    totals = result["totals"]
    values = [(f"{totals['mapped']} of {totals['recordings']}", "recordings mapped")]
    if totals["distance_m"] is not None:
        values.append((f"{totals['distance_m']:.0f} m", "traveled"))
    if totals["duration_s"] is not None:
        values.append((f"{totals['duration_s'] / 3600.0:.2f} h", "recorded"))
    for name, title in (("relations_m", "relations"), ("ate_m", "ATE")):
        if f"median_{name}" in totals:
            values.append((f"{totals['median_' + name]:.4f} m", f"{title}, median"))
            values.append((f"{totals['largest_' + name]:.4f} m", f"{title}, largest"))
    if "largest_lost_share" in totals:
        values.append((f"{totals['largest_lost_share'] * 100.0:.2f} %", "lost scans, largest"))
    return "".join(f'<div class="card"><b>{html.escape(value)}</b>'
                   f'<span class="soft">{html.escape(name)}</span></div>'
                   for value, name in values)


def items_of(title, lines):
    if not lines:
        return ""
    items = "".join(f"<p>{html.escape(line)}</p>" for line in lines)
    return f'<h2>{title}</h2><section class="card warnings">{items}</section>'


def comparison_of(comparison):
    if comparison is None:
        return ""
    titles = ["recording", "verdict", "status", *map(title_of, CHANGED), "remarks"]
    rows = "".join(change_line(change) for change in comparison["changes"])
    names = "".join(f"<p>Only {which}: {html.escape(', '.join(comparison[key]))}</p>"
                    for which, key in (("in this batch", "new"), ("in the old batch", "gone"))
                    if comparison[key])
    return (f"<h2>Against {html.escape(comparison['old'])}</h2>"
            f"<p>{comparison['worse']} worse, {comparison['better']} better. "
            f"Commit {html.escape(', '.join(comparison['old_commits']) or '?')} → "
            f"{html.escape(', '.join(comparison['commits']) or '?')}. Worse results come first. "
            "Worse or better: an error that changed by more than 10 %, or more than 1 % of the "
            f"scans.</p>{names}<section class=\"card scroll\"><table class=\"sortable\"><thead>"
            f"{head_of(titles)}</thead><tbody>{rows}</tbody></table></section>")


def change_line(change):
    cells = [f'<td>{link(change["name"], change["status"][1])}</td>',
             f'<td class="{change["verdict"]}">{change["verdict"]}</td>',
             f'<td>{html.escape(" → ".join(dict.fromkeys(change["status"])))}</td>']
    for name, _, unit, decimals in CHANGED:
        old, new = change[name]
        text = " → ".join(dict.fromkeys([cell(old, unit, decimals), cell(new, unit, decimals)]))
        difference = "" if None in (old, new) else new - old
        cells.append(f'<td data-value="{difference}">{text}</td>')
    remarks = [text for key, text in (("other_input", "other input"),
                                      ("other_parameters", "other parameters")) if change[key]]
    return f"<tr>{''.join(cells)}<td>{', '.join(remarks)}</td></tr>"


def head_of(titles):
    return "<tr>" + "".join(f"<th><button>{html.escape(title)}</button></th>"
                            for title in titles) + "</tr>"


def link(name, status):
    target = "report.html" if status == "ok" else "log.txt"
    return f'<a href="maps/{html.escape(name)}/{target}">{html.escape(name)}</a>'


def line_of(row, shown):
    name, mapped = html.escape(row["name"]), row["status"] == "ok"
    picture = (f'<a href="maps/{name}/report.html"><img src="maps/{name}/thumbnail.png" alt="" '
               'loading="lazy"></a>') if mapped else ""
    message = f'<div class="soft">{html.escape(row["message"])}</div>' if row["message"] else ""
    cells = [f"<td>{picture}</td>", f"<td>{link(row['name'], row['status'])}</td>",
             f'<td class="{"" if mapped else "worse"}">{row["status"]}{message}</td>']
    for key, _, unit, decimals in shown:
        value = row[key]
        cells.append(f'<td data-value="{"" if value is None else value}">'
                     f"{cell(value, unit, decimals)}</td>")
    return f"<tr>{''.join(cells)}</tr>"
