#!/usr/bin/env bash
# The published trade-off of this machine, made anew: every model's time and error. The machine has to be quiet. Takes
# ten minutes or more on two cores.
#
#   scripts/tradeoff.sh NAME [options of tradeoff]   writes docs/results/NAME.json and NAME.md,
#                                                    docs/pictures/tradeoff.svg, and the README's plot, presets.svg
#   scripts/tradeoff.sh NAME --page                  only the page and the README's plot, of the JSON that is there
#
# RAINDROPS names the program, else it is built. Exit status: 0; 2 for an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
[ $# -gt 0 ] && [[ $1 != -* ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' scripts/tradeoff.sh >&2; exit 2; }
name=$1
shift
fail() { echo "tradeoff: $*" >&2; exit 2; }
json=docs/results/$name.json
if [ "${1-}" != --page ]; then
  if [ -z "${RAINDROPS-}" ]; then
    scripts/setup.sh
    scripts/cargo.sh build --release --locked --bin raindrops || fail "the program does not build"
    RAINDROPS=target/release/raindrops
  fi
  export RAINDROPS
  # What was published stays until all of it is measured.
  mkdir -p out/results
  "$RAINDROPS" tradeoff "$@" --json "out/results/$name.json" --svg out/results/tradeoff.svg || fail "no result; what was measured is in out/results"
  cp "out/results/$name.json" "$json"
  cp out/results/tradeoff.svg docs/pictures/
  RESULT=$json scripts/made.sh scripts/tradeoff.sh tradeoff.svg presets.svg
fi

python3 - "$json" "docs/results/$name.md" <<'PYTHON' || fail "no page"
import json, os, re, sys
result = json.load(open(sys.argv[1]))
host, device, build, rows = (result[key] for key in ("host", "device", "build", "rows"))
scenes = list(dict.fromkeys(row["scene"] for row in rows))
by_rate = [[s for s in scenes if any(r["scene"] == s and (r.get("rate_mm_h") is not None) == is_rain for r in rows)]
           for is_rain in (False, True)]

def cell(scene, model):
    for row in rows:
        if (row["scene"], row["model"]) == (scene, model):
            mark = "**" if row["pareto"] else ""
            return f"{mark}{row['speed']:.2f} / {255 * row['rms']:.2f}{mark}"
    return ""

def table(scenes):
    models = dict.fromkeys(row["model"] for row in rows if row["scene"] in scenes)
    lines = ["| speed / rms | " + " | ".join(scenes) + " |", "|---" * (len(scenes) + 1) + "|"]
    lines += [f"| `{model}` | " + " | ".join(cell(scene, model) for scene in scenes) + " |" for model in models]
    noise = {of["scene"]: f"{255 * of['rms']:.2f}" for of in result.get("noise", [])}
    lines.append("| *noise* | " + " | ".join(f"/ {noise[scene]}" if scene in noise else "" for scene in scenes) + " |")
    return lines

def sizes(scenes):
    first = {row["scene"]: row for row in reversed(rows) if row["speed"] == 1.0}
    return "Sizes, and the first model's time: " + "; ".join(
        f"{scene} {of['width']} x {of['height']}, {of['median_ms']:,.2f} ms" for scene in scenes if (of := first.get(scene))) + "."

# The load at the start, if the result has it.
load = f", load {host['load']:.2f} when it began" if host.get("load") is not None else ""
page = [
    "# Every model's time and error",
    "",
    f"Made by `scripts/tradeoff.sh` from [{sys.argv[1].rsplit('/', 1)[-1]}]({sys.argv[1].rsplit('/', 1)[-1]}), which has all figures;",
    "its keys are those of [result files](../result-files.md). [Plot](../pictures/tradeoff.svg).",
    "",
    f"- {device['name']}, {device['driver_info']}",
    f"- {host['cpu']}, {host['cores']} cores{load}; raindrops {build['version']} {build['commit']} {build['profile']}",
    f"- truth: {result['truth_samples']} samples a pixel",
    "",
    "Speed is a multiple of `paper`'s, which ran in turn with the model; rms is in grey levels of 255, tone mapped. A cell in",
    "bold is on the Pareto front: no other model of the scene is both faster and truer. Two models that are the same program",
    "by two names, such as `auto` and its choice, show how far times differ by chance. The row *noise* has the rms that a picture",
    "without any error would have, as the truth is noisy: where a model's is hardly above it, the model's own error is smaller, and not known.",
    "",
    *table(by_rate[0]),
    "",
    sizes(by_rate[0]),
]
if by_rate[1]:
    page += ["", "With real rain, which `paper` does not draw, speed is a multiple of `fast`'s:", "", *table(by_rate[1]), "", sizes(by_rate[1])]
moving = [row for row in rows if row.get("flicker") is not None]
for scene in dict.fromkeys(row["scene"] for row in moving):
    page += ["", f"Flicker of the scene {scene}: RMS of what a model changes from frame to frame and the truth does not, in grey levels.",
             "", "| model | flicker |", "|---|---|"]
    page += [f"| `{row['model']}` | {255 * row['flicker']:.2f} |" for row in moving if row["scene"] == scene]
# Notes that somebody wrote on this commit's figures stay; those on others are of no use.
heading = f"\n## Notes on commit {build['commit']}\n"
before = open(sys.argv[2]).read() if os.path.exists(sys.argv[2]) else ""
notes = heading + before.split(heading)[1] if heading in before else ""
open(sys.argv[2], "w").write("\n".join(page) + "\n" + notes)

# The README's plot: time against error of the presets in the scene "far", one million drops, and the noise of the truth.
from math import log10
of = {row["model"]: row for row in rows if row["scene"] == "far"}
noise = next(255 * entry["rms"] for entry in result["noise"] if entry["scene"] == "far")
x = lambda ms: 70 + 550 * log10(ms / 5) / log10(20000 / 5)
y = lambda rms: 330 - 280 * log10(rms / 0.8) / log10(12 / 0.8)
text = lambda at, down, words, anchor="middle", size=13: f'<text x="{at:.0f}" y="{down:.0f}" text-anchor="{anchor}" font-size="{size}">{words}</text>'
first = of["paper"]
svg = ['<svg xmlns="http://www.w3.org/2000/svg" width="660" height="420" viewBox="0 0 660 420" font-family="sans-serif">', '<rect width="660" height="420" fill="#fff"/>',
       text(345, 28, f"{first['drops']:,} drops, {first['width']} x {first['height']}: time against error", size=16)]
for ms in (10, 100, 1000, 10000):
    svg += [f'<path d="M{x(ms):.0f} 50V330" stroke="#ccc"/>', text(x(ms), 350, f"{ms:,}")]
for rms in (1, 2, 5, 10):
    svg += [f'<path d="M70 {y(rms):.0f}H620" stroke="#ccc"/>', text(62, y(rms) + 4, rms, "end")]
svg += [f'<path d="M70 {y(noise):.0f}H620" stroke="#000" stroke-dasharray="6 4"/>',
        text(612, y(noise) - 7, f"noise of the reference {noise:.1f}: a perfect picture would be here", "end"),
        text(345, 372, "ms a frame"), f'<g transform="rotate(-90 22 190)">{text(22, 190, "RMS error, levels of 255")}</g>',
        text(345, 398, f"{device['driver']} {device['driver_info']}", size=11),
        text(345, 412, f"{host['cpu']}, {host['cores']} cores, commit {build['commit'][:7]}", size=11)]
# Where a label stands beside its point: `auto` mostly has the error of `fast`, and nearly its time.
places = {"paper": ("#d55e00", 0, -14, "middle"), "fast": ("#0072b2", 0, 22, "middle"), "auto": ("#009e73", 12, -12, "start"), "exact": ("#cc79a7", 0, -14, "middle")}
for model, (colour, right, down, anchor) in places.items():
    at, up = x(of[model]["median_ms"]), y(255 * of[model]["rms"])
    words = f"{model}: {of[model]['median_ms']:,.0f} ms, {255 * of[model]['rms']:.1f}"
    svg += [f'<circle cx="{at:.1f}" cy="{up:.1f}" r="6" fill="{colour}"/>', text(at + right, up + down, words, anchor, 14)]
open("docs/pictures/presets.svg", "w").write("\n".join(svg) + "\n</svg>\n")

readme = open("README.md").read()
readme = re.sub(r"(results/2026[^)]*tradeoff\.md\) \(commit )[0-9a-f]+", lambda found: found[1] + build["commit"][:7], readme)
open("README.md", "w").write(readme)
PYTHON
