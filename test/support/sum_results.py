#!/usr/bin/python3
"""Adds up the JUnit files below a folder: names what failed, ends with `N passed, N failed, N skipped`."""
import glob
import os
import sys
import xml.etree.ElementTree as ElementTree


def outcomes(path):
    """Yields (name, "passed" | "failed" | "skipped") for each test case of a file."""
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError:
        yield os.path.basename(path) + " (no readable result)", "failed"
        return
    for case in root.iter("testcase"):
        if case.get("name", "").startswith("_ctest_"):
            continue  # of ctest's own list: a program that leaves a file of its own, which says more
        name = f"{case.get('classname', '')}.{case.get('name', '')}"
        if case.find("failure") is not None or case.find("error") is not None:
            yield name, "failed"
        elif case.find("skipped") is not None or case.get("status") == "notrun":
            yield name, "skipped"
        else:
            yield name, "passed"


def main():
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    for path in sorted(glob.glob(os.path.join(sys.argv[1], "**", "*.xml"), recursive=True)):
        for name, outcome in outcomes(path):
            counts[outcome] += 1
            if outcome == "failed":
                print("FAILED", name)
    print("{passed} passed, {failed} failed, {skipped} skipped".format(**counts))
    return 1 if counts["failed"] or not counts["passed"] else 0


if __name__ == "__main__":
    sys.exit(main())
