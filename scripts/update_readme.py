#!/usr/bin/python3
"""Puts what the commands print into README.md: the table of parameters, and with --figures the measured figures.

  scripts/update_readme.py            the table of parameters
  scripts/update_readme.py --check    fails when that table is not what the programs say
  scripts/update_readme.py --figures [NAME ...]
                                      also runs the demo, the studies, the real data, GPS withheld and the benchmark, or only those named
                                      as their marks in README.md, and puts in their last output
  scripts/update_readme.py --faults FILE.json   puts in what scripts/faults.py --json FILE.json has written
  scripts/update_readme.py --dates    when the figures were measured, into docs/results.md
"""
import argparse
import datetime
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
README = os.path.join(ROOT, "README.md")
RESULTS = os.path.join(ROOT, "docs", "results.md")
ENVIRONMENT = os.path.join(ROOT, "build", "devel", "env.sh")


def output_of(*command):
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.strip("\n")


def put(text, name, content):
    """Replaces what stands between the marks `<!-- name -->` and `<!-- /name -->`."""
    pattern = re.compile(rf"(<!-- {name} -->\n)(?:.*?\n)?(<!-- /{name} -->)", re.DOTALL)
    if not pattern.search(text):
        sys.exit(f"update_readme.py: README.md has no marks <!-- {name} --> ... <!-- /{name} -->")
    return pattern.sub(lambda match: match.group(1) + content + "\n" + match.group(2), text)


# What was measured: mark in README.md, how the figures are called, command, configuration.
FIGURES = (
    ("demo", "the demo", "`scripts/demo.sh`", "`bags/room.bag`, `config/slam.yaml`"),
    ("real data", "recorded data by others", "`scripts/evaluate_real_data.py --estimators`",
     "`config/mrclam.yaml`, `mrclam_unknown.yaml`, `turtlebot3.yaml`, `victoria_park.yaml`, `husky.yaml`"),
    ("refined", "the batch optimum", "`scripts/evaluate_real_data.py --refine`", "`config/mrclam.yaml`"),
    ("study", "the simulated room", "`slam_study room --seeds 100`", "`config/worlds/room.yaml`, `config/slam.yaml`"),
    ("hard study", "the room on a bad day", "`slam_study room --world config/worlds/room_hard.yaml`", "`config/slam.yaml`"),
    ("consistency", "whether the covariance tells the truth", "`slam_study consistency`", "the textbook's noise, 50 seeds"),
    ("global map", "several maps, one frame", "`slam_study global`", "buoys and landmarks in parts of the way, 50 seeds"),
    ("benchmark", "time and memory", "`scripts/benchmark.sh --mrpt`", "8 landmarks in view, identities known"),
    ("node", "how soon the node answers", "`scripts/benchmark.sh --node`", "`bags/room.bag`, `config/slam.yaml`"),
)


def last_changed(name):
    """The newest date of the lines between the marks; lines that are not committed are of today."""
    with open(README, encoding="utf-8") as file:
        lines = file.read().split("\n")
    first, last = lines.index(f"<!-- {name} -->") + 2, lines.index(f"<!-- /{name} -->")
    blame = output_of("git", "blame", "--line-porcelain", "-L", f"{first},{last}", "README.md")
    newest = max(map(int, re.findall(r"^committer-time (\d+)$", blame, re.MULTILINE)))
    return datetime.date.fromtimestamp(newest).isoformat()


def table_of_dates():
    rows = [f"| {title} | {command} | {configuration} | {last_changed(name)} |" for name, title, command, configuration in FIGURES]
    return "\n".join(["| what | command | configuration | figures last changed |", "|---|---|---|---|", *rows])


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def write_dates():
    with open(RESULTS, encoding="utf-8") as file:
        text = file.read()
    write(RESULTS, put(text, "measured", table_of_dates()))


def fenced(content):
    return "```\n" + content + "\n```"


def demo_summary():
    """What the demo prints below its last heading."""
    return output_of("scripts/demo.sh").rsplit("== Result\n", 1)[-1]


def benchmark_tables():
    """All but the name of the picture."""
    return output_of("scripts/benchmark.sh", "--mrpt").rsplit("\n", 1)[0].strip()


def consistency_figures():
    """The study in both spaces with both sensors."""
    tables = []
    for space in ("planar", "spatial"):
        for sensor, meaning in (("far", "up to 5 m"), ("kinect", "0.6 to 2.6 m")):
            tables.append(f"{space}, sensor {meaning}, 57 degrees wide\n" +
                          output_of(ENVIRONMENT, "slam_study", "consistency", "--space", space, "--sensor", sensor))
    return "\n".join(tables)


# What stands between the marks of README.md.
MEASURED = {
    "study": lambda: output_of(ENVIRONMENT, "slam_study", "room", "--seeds", "100"),
    "hard study": lambda: output_of(ENVIRONMENT, "slam_study", "room", "--world", "config/worlds/room_hard.yaml"),
    "consistency": consistency_figures,
    "global map": lambda: output_of(ENVIRONMENT, "slam_study", "global"),
    "real data": lambda: output_of("scripts/evaluate_real_data.py", "--estimators"),
    "refined": lambda: output_of("scripts/evaluate_real_data.py", "--refine"),
    "withheld": lambda: output_of("scripts/evaluate_withheld.py"),
    "demo": demo_summary,
    "benchmark": benchmark_tables,
    "node": lambda: output_of("scripts/benchmark.sh", "--node"),
}


def table_of_faults(path):
    sys.path.insert(0, os.path.join(ROOT, "test", "faults"))
    from row import Row, table
    with open(path, encoding="utf-8") as file:
        return table([Row(**row) for row in json.load(file).values()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing, fail when the table is out of date")
    parser.add_argument("--figures", nargs="*", choices=MEASURED, metavar="NAME",
                        help="also measure anew (minutes), all or those named: " + ", ".join(MEASURED))
    parser.add_argument("--faults", metavar="FILE.json", help="also the table of faults, of that file")
    parser.add_argument("--dates", action="store_true", help="tell in docs/results.md when the figures last changed")
    arguments = parser.parse_args()
    if arguments.dates:
        write_dates()
        return
    with open(README, encoding="utf-8") as file:
        before = file.read()
    after = put(before, "parameters", output_of(ENVIRONMENT, "slam_replay", "--parameters"))
    if arguments.figures is not None:
        for name in arguments.figures or MEASURED:
            after = put(after, name, fenced(MEASURED[name]()))
    if arguments.faults:
        after = put(after, "faults", table_of_faults(arguments.faults))
    if arguments.check:
        if after != before:
            sys.exit("update_readme.py: README.md is not what slam_replay --parameters prints; run scripts/update_readme.py")
        return
    write(README, after)
    if arguments.figures is not None:
        write_dates()


if __name__ == "__main__":
    main()
