"""The report as one page: plots inline, every row as a table, nothing fetched. Made from the rows' file alone.

python bench/page.py ROWS.json [REPORT.html]            the page again
python bench/page.py compare OLDER.json NEWER.json      rows of two runs, in D, side by side
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from charts import Series, lines, ratios, stacked
from common import told
from drawing import ORDER

STYLE = """
body { font: 15px/1.45 system-ui, "Liberation Sans", Arial, sans-serif; color: #111; background: #fff }
body { margin: 2em auto; max-width: 1120px; padding: 0 1em }
h1 { font-size: 1.7em; margin-bottom: .2em } h2 { margin-top: 2em; border-bottom: 2px solid #111 } h3 { margin-bottom: .3em }
.plots { display: flex; flex-wrap: wrap; align-items: flex-start; gap: 14px 24px }
svg { max-width: 100%; height: auto; font-family: inherit; break-inside: avoid }
table { border-collapse: collapse; font-size: 13px; margin: .6em 0 } th, td { padding: 3px 9px; text-align: right; vertical-align: top }
th { border-bottom: 1.5px solid #111 } td { border-bottom: 1px solid #ccc; font-variant-numeric: tabular-nums }
th:first-child, td:first-child, .said { text-align: left } .missed { font-weight: 700; color: #a33c00 } .met { color: #00573f }
.loud { border: 2px solid #a33c00; padding: .2em 1em } .number { font-size: 1.15em } small { color: #444 }
@media print { body { margin: 0; max-width: none; font-size: 11px } table, svg { break-inside: avoid } h2 { break-after: avoid } }
"""
PEERS = """<h2>Against other programs: seconds to equal tone error</h2><p class=number>scikit-image's camera at 1000 px. Tone error
is the root mean square after a Gaussian of 8 px, dots being equal discs whose areas sum to the ink, 1 - v/255. Each peer takes the
passes that are its own or published; ours stops at the first step that is as good.</p>"""
PEERS_READ = """<p><small>rho is a dot's distance to the nearest other over a hexagon's for its own cell: evenness, which tone error
does not see; it counts as equal from .005 below on. To equal tone: seconds of ours in a warm process, from the picture's array to the
sites, and how many times as long the peer's loop takes, by the clock and in CPU seconds. Command line: all of <code>crowquill
stipple</code>, from picture file to SVG, at equal tone, against all of the peer's process; inksep's and plotline's write an SVG too,
the others no drawing. A halftone is one pass and leaves its dots on a grid, uneven; there ours is no sooner, only more even.</small></p>"""
MEMORY = {"whole drawing": "memory", "iterations alone": "iteration_memory"}
Row = dict[str, Any]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; cells are HTML already, and the last column is words."""
    top = "".join(f"<th scope=col>{escape(name)}" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{cell}" for cell in row[:-1]) + f"<td class=said>{row[-1]}" for row in rows)
    return f"<table><thead><tr>{top}</thead><tbody>{body}</tbody></table>"


def html(data: dict[str, Any]) -> str:
    """The whole page."""
    sections = [opening(data), against(data), bars(data), growth(data), solving(data), everything(data), missing(data)]
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>crowquill: what drawing costs</title><style>{STYLE}</style>" + "".join(sections) + "</html>\n"
    )


def opening(data: dict[str, Any]) -> str:
    """What was run, on what, and how to read it."""
    machine, ds = data["machine"], data["d"]
    low, high = (f(d["seconds"] for d in ds) for f in (min, max)) if ds else (0.0, 0.0)
    loads = [d["load"] for d in ds]
    versions = ", ".join(f"{name} {number}" for name, number in machine["versions"].items())
    drift = f"{low:.3f} s" if high < 1.05 * low else f"{low:.3f} to {high:.3f} s in the course of the run, and a row's is that of its part"
    load = f"Load when its parts began: {min(loads):.1f} to {max(loads):.1f}." if loads else ""
    busy = " <b>Other work ran too: times by the clock are longer than alone.</b>" if loads and max(loads) > machine["cores"] + 0.5 else ""
    short = " This was a quick run: fewer dots, smaller pictures, no plates and no editor." if data.get("quick") else ""
    return (
        f"<h1>What drawing costs</h1><p>{escape(machine['processor'])}, {machine['cores']} processors, {machine['memory_gb']} GB; "
        f"{escape(machine['system'])}; {machine['when'].replace('T', ' ')}. {load}{busy}{short}<br><small>{escape(versions)}</small></p>"
        f"<p><b>D</b> is the time of <code>scipy.spatial.Delaunay</code> on 100 000 uniform random sites: {drift}. "
        "Seconds are the least of repeated runs, by the clock; CPU seconds add up all processors.</p>"
    )


def against(data: dict[str, Any]) -> str:
    """Every peer, and how much sooner or later ours is as good."""
    found: list[Row] = data["figures"].get("peers", [])
    if not found:
        return "<h2>Against other programs</h2><p>not run</p>"
    head = ("peer", "dots", "tone error", "rho", "seconds", "CPU s", "to equal tone", "to that and evenness", "command line", "how")
    return f"{PEERS}<div class=plots>{versus(data)}</div>{table(head, [peer_row(line) for line in found])}{PEERS_READ}"


def versus(data: dict[str, Any]) -> str:
    """The ratios as plots, at equal tone and at equal evenness too."""
    plots, found = [], data["figures"].get("peers", [])
    for goal, words in (("near", "equal tone error"), ("even", "equal tone error and equal evenness")):
        rows = [(f"{line['peer']}, {line['dots']} dots", line[goal]["ratio"]) for line in found if goal in line]
        plots.append(ratios(f"Seconds to {words}: theirs over ours", "times as fast; loops alone, in a warm process", rows))
    return "".join(plots)


def peer_row(line: Row) -> list[str]:
    """A peer's row of the table."""
    loop, cells = line["loop"], [escape(line["peer"]), f"{line['dots']}", f"{line['tone']:.4f}", f"{line['rho']:.3f}"]
    cells += [f"{loop['least']:.3f}", f"{loop['cpu']:.3f}"]
    for goal in ("near", "even"):
        if ours := line.get(goal):
            word = "ahead" if ours["ratio"] >= 1 else "<span class=missed>behind</span>"
            cells.append(f"{ours['seconds']:.3f} s: <b>{ours['ratio']:.3g}</b> {word}, CPU {ours['cpu_ratio']:.3g}")
        else:
            cells.append("<span class=missed>not reached</span>")
    ours = line.get("command")
    cells.append(
        f"{ours['seconds']:.2f} s to {line['run']['seconds']:.2f}: <b>{ours['ratio']:.3g}</b>, CPU {ours['cpu_ratio']:.3g}" if ours else "-"
    )
    steps = "; ours ".join(f"{escape(line[goal]['solver'])}, after {line[goal]['step']:.0f}" for goal in ("near", "even") if goal in line)
    return [*cells, f"{line['passes']}; ours {steps}"]


def bars(data: dict[str, Any]) -> str:
    """What was held to a limit."""
    rows = [row for row in data["rows"] if row.get("bar") is not None]
    cells = [
        [escape(row["what"].strip()), f"{row['got']:.2f} {escape(row['unit'])}", ("at least " if row["least"] else "") + f"{row['bar']:g}",
         "<span class=met>met</span>" if row["met"] else "<span class=missed>missed</span>"]
        for row in rows
    ]  # fmt: skip
    met = sum(row["met"] for row in rows)
    return f"<h2>Bars</h2><p>{met} of {len(rows)} met.</p>" + table(("what", "measured", "bar", ""), cells)


def growth(data: dict[str, Any]) -> str:
    """Time, memory and stages over dots and pixels."""
    out = "<h2>How it grows</h2>"
    for axis, unit, key in (("dots", "dots, on 1 Mpx", "dots"), ("pixels", "Mpx", "side")):
        points: list[Row] = data["figures"].get(axis, [])
        if not points:
            out += f"<p>over {axis}: not run</p>"
            continue
        x = [point[key] if key == "dots" else point["side"] ** 2 / 1e6 for point in points]
        across = unit if key == "dots" else f"Mpx, {points[0]['dots']} dots"
        whole = Series(f"whole drawing, {points[-1]['iterations']} iterations", x, [point["seconds"] for point in points])
        one = Series("one iteration", x, [point["iteration"] for point in points])
        cpu = Series("whole drawing, CPU seconds", x, [point["cpu"] for point in points])
        memory = [Series(name, x, [point[of] for point in points]) for name, of in MEMORY.items()]
        out += f"<div class=plots>{lines(f'Time over {axis}', across, 'seconds', [whole, cpu, one])}"
        out += lines(f"Memory over {axis}", across, "MB at most (VmHWM)", memory)
        if key == "dots":
            many = [point for point in points if point["dots"] >= 1e4]
            parts = [(f"{point['dots']}", {k: 1e6 * v / point["dots"] for k, v in point["stages"].items()}) for point in many]
            out += stacked("Stages of a whole drawing, by dots", "microseconds a dot", parts, ORDER)
            kinds = {"whole drawing": "seconds", "one iteration": "iteration"}
            per = [Series(name, x, [1e6 * point[of] / point["dots"] for point in points]) for name, of in kinds.items()]
            out += lines("Time a dot", across, "microseconds a dot", per)
        else:
            parts = [(f"{mpx:g} Mpx", point["stages"]) for mpx, point in zip(x, points, strict=True)]
            out += stacked("Stages of a whole drawing, by pixels", "seconds", parts, ORDER)
        out += "</div>"
    return out


def solving(data: dict[str, Any]) -> str:
    """Energy and tone error over seconds, by number of dots."""
    out = "<h2>Solvers</h2><p>The camera at 1000 px, from the picture's array on: a marker is a step that was looked at. Energy is the "
    out += "integral of coverage squared times squared distance to the nearest dot.</p>"
    for dots, ways in data["figures"].get("solvers", {}).items():
        out += "<div class=plots>"
        least = min(point["energy"] for way in ways.values() for point in way)
        for title, up, value in (
            ("Energy", "over the least of all, less 1", lambda point, least=least: point["energy"] / least - 1),
            ("Tone error", "rmse after 8 px", lambda point: point["tone"]),
        ):
            series = [Series(name, [point["seconds"] for point in way], [value(point) for point in way]) for name, way in ways.items()]
            out += lines(f"{title} of {dots} dots", "seconds", up, series)
        out += "</div>"
    return out


def everything(data: dict[str, Any]) -> str:
    """Every row, by part."""
    out = "<h2>All rows</h2>"
    for part in data["parts"]:
        rows = [row for row in data["rows"] if row["part"] == part]
        lines_ = [row["what"] for row in rows if "seconds" not in row]
        cells = [
            [escape(row["what"]), f"{row['seconds']:.3f}", f"{row['mean']:.3f} ± {row['spread']:.3f}", f"{row['cpu']:.3f}",
             f"{row['d']:.2f}", escape("; ".join(filter(None, [row["said"], told(row)])))]
            for row in rows if "seconds" in row
        ]  # fmt: skip
        out += f"<h3>{escape(part)}</h3>"
        out += table(("what", "least s", "mean s", "CPU s", "D", ""), cells) if cells else ""
        out += f"<pre>{escape(chr(10).join(lines_))}</pre>" if lines_ else ""
    return out


def missing(data: dict[str, Any]) -> str:
    """What was not run, loudly."""
    rows = "".join(f"<li><b>{escape(one['what'])}</b>: {escape(one['why'])}" for one in data["missing"])
    return f"<h2>Not run</h2><div class=loud><ul>{rows}</ul></div>" if rows else "<h2>Not run</h2><p>All was run.</p>"


def written(data: dict[str, Any], file: Path) -> None:
    """Writes the page."""
    file.write_text(html(data), encoding="utf-8")


def compared(older: dict[str, Any], newer: dict[str, Any]) -> list[str]:
    """Rows that both runs have, in D, and how the newer one's is to the older one's; those of one run only last."""
    rows = [{row["what"].strip(): row["d"] for row in data["rows"] if "d" in row} for data in (older, newer)]
    pairs = {what: (d, rows[1][what]) for what, d in rows[0].items() if what in rows[1]}
    both = [f"{what:<80} {old:9.3f} D {new:9.3f} D {new / (old or 1e-9):6.2f} times" for what, (old, new) in pairs.items()]
    only = [f"{what:<80} only in the {('older', 'newer')[k]}" for k in (0, 1) for what in rows[k] if what not in rows[1 - k]]
    return both + only


if __name__ == "__main__":
    words = sys.argv[1:]
    if len(words) not in (1, 2, 3) or (words[0] == "compare") != (len(words) == 3):
        sys.exit(__doc__)
    files = [json.loads(Path(word).read_text(encoding="utf-8")) for word in words if word.endswith(".json")]
    if words[0] == "compare":
        print("\n".join(compared(*files)))
    else:
        written(files[0], Path(words[1]) if len(words) > 1 else Path(words[0]).with_name("report.html"))
