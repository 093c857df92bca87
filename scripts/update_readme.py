#!/usr/bin/python3
"""Puts what the commands print into README.md: the table of parameters, and with --figures the measured figures.

  scripts/update_readme.py            the table of parameters
  scripts/update_readme.py --check    fails when that table is not what the programs say
  scripts/update_readme.py --figures  also runs the demo, the study, the real data, GPS withheld and the benchmark, and puts in their last output
"""
import argparse
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
README = os.path.join(ROOT, "README.md")
ENVIRONMENT = os.path.join(ROOT, "build", "devel", "env.sh")


def output_of(*command):
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def put(text, name, content):
    """Replaces what stands between the marks `<!-- name -->` and `<!-- /name -->`."""
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(\n<!-- /{name} -->)", re.DOTALL)
    if not pattern.search(text):
        sys.exit(f"update_readme.py: README.md has no marks <!-- {name} --> ... <!-- /{name} -->")
    return pattern.sub(lambda match: match.group(1) + content + match.group(2), text)


def fenced(content):
    return "```\n" + content + "\n```"


def demo_summary():
    """What the demo prints below its last heading."""
    return output_of("scripts/demo.sh").rsplit("== Result\n", 1)[-1]


def benchmark_tables():
    """All but the name of the picture."""
    return output_of("scripts/benchmark.sh", "--quick", "--mrpt").rsplit("\n", 1)[0].strip()


def consistency_figures():
    """The study in both spaces with both sensors."""
    tables = []
    for space in ("planar", "spatial"):
        for sensor, meaning in (("far", "up to 5 m"), ("kinect", "0.6 to 2.6 m")):
            tables.append(f"{space}, sensor {meaning}, 57 degrees wide\n" +
                          output_of(ENVIRONMENT, "slam_study", "consistency", "--space", space, "--sensor", sensor))
    return "\n".join(tables)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing, fail when the table is out of date")
    parser.add_argument("--figures", action="store_true", help="also measure anew (minutes)")
    arguments = parser.parse_args()
    with open(README, encoding="utf-8") as file:
        before = file.read()
    after = put(before, "parameters", output_of(ENVIRONMENT, "slam_replay", "--parameters"))
    if arguments.figures:
        after = put(after, "study", fenced(output_of(ENVIRONMENT, "slam_study", "room", "--seeds", "100")))
        after = put(after, "hard study", fenced(output_of(ENVIRONMENT, "slam_study", "room", "--world", "config/worlds/room_hard.yaml")))
        after = put(after, "consistency", fenced(consistency_figures()))
        after = put(after, "real data", fenced(output_of("scripts/evaluate_real_data.py", "--estimators")))
        after = put(after, "withheld", fenced(output_of("scripts/evaluate_withheld.py")))
        after = put(after, "demo", fenced(demo_summary()))
        after = put(after, "benchmark", fenced(benchmark_tables()))
    if arguments.check:
        if after != before:
            sys.exit("update_readme.py: README.md is not what slam_replay --parameters prints; run scripts/update_readme.py")
        return
    with open(README, "w", encoding="utf-8") as file:
        file.write(after)


if __name__ == "__main__":
    main()
