#!/usr/bin/python3
"""Does to the package what happens to robots, and prints what came of it: fault, how many, what must hold, result.

  scripts/faults.py [--quick] [--only ROW ...] [--json FILE]

Rows: {rows}.
Exit code 1: something does not hold. scripts/build.sh comes first; what needs sanitizers is built on the way
(scripts/build_sanitized.sh), but not for --quick. All rows take hours: README.md has the table.
"""
import argparse
import dataclasses
import json
import os
import signal
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
ENVIRONMENT = os.path.join(ROOT, "build", "devel", "env.sh")


def use_environment():
    """Starts the script again with the build's packages found."""
    if os.environ.get("FAULTS_ENVIRONMENT") != ROOT:
        if not os.path.exists(ENVIRONMENT):
            sys.exit("faults.py: nothing is built: run scripts/build.sh first")
        os.environ["FAULTS_ENVIRONMENT"] = ROOT
        os.execv(ENVIRONMENT, [ENVIRONMENT, "/usr/bin/python3", *sys.argv])


if __name__ == "__main__":
    use_environment()
for folder in ("support", "faults"):
    sys.path.insert(0, os.path.join(ROOT, "test", folder))

import damaged_files  # noqa: E402
import damaged_messages  # noqa: E402
import endurance  # noqa: E402
import kill  # noqa: E402
import sensors  # noqa: E402
import threads  # noqa: E402
from master import own_master  # noqa: E402
from row import Row, table  # noqa: E402

ROWS = {"kill": kill.kill, "files": damaged_files.parsers, "bag-messages": damaged_files.bag_messages, "bags": damaged_files.bags, "pipeline": damaged_messages.pipeline,
        "perception": damaged_messages.perception, "node": damaged_messages.node, "patrol": endurance.patrol,
        "dropouts": sensors.dropouts, "clock": sensors.clock, "transforms": sensors.transforms, "rates": sensors.rates,
        "threads": threads.threads}


def read_rows(path):
    """{name: Row} of a file that an earlier run has written; none: {}."""
    if not path or not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        return {name: Row(**row) for name, row in json.load(file).items()}


def write_rows(path, rows):
    with open(path, "w", encoding="utf-8") as file:
        json.dump({name: dataclasses.asdict(rows[name]) for name in ROWS if name in rows}, file, indent=1)
        file.write("\n")


def run(names, quick, path):
    rows = {}
    with own_master():
        for name in names:
            print(f"{name} ...", file=sys.stderr, flush=True)
            rows[name] = ROWS[name](quick)
            if path:
                write_rows(path, {**read_rows(path), **rows})
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.format(rows=", ".join(ROWS)), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few of each: minutes in all")
    parser.add_argument("--only", nargs="+", choices=ROWS, default=list(ROWS), metavar="ROW", help="these rows alone")
    parser.add_argument("--json", metavar="FILE", help="the rows as JSON as well; rows of an earlier run that are not run now stay")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that the master and what is running end as well
    rows = run(arguments.only, arguments.quick, arguments.json)
    print(table(rows.values()))
    return 0 if all(row.holds for row in rows.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
