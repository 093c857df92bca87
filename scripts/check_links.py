#!/usr/bin/python3
"""Checks that relative links and anchors of the repository's Markdown files lead somewhere; no network.

  scripts/check_links.py [FILE.md ...]     without files: all that git knows or could add
"""
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from slam_tools.markdown import LINK, anchors, without_code  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def broken_links(path):
    """What is wrong in a file, a line each."""
    for number, line in enumerate(without_code(read(path)).split("\n"), 1):
        for _, _, target in LINK.findall(line):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            linked = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
            where = f"{os.path.relpath(path, ROOT)}:{number}: {target}"
            if not os.path.exists(linked):
                yield f"{where}: there is no such file"
            elif anchor and linked.endswith(".md") and anchor not in anchors(read(linked)):
                yield f"{where}: no heading has that anchor"


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__)
        return
    files = sys.argv[1:]
    if not files:
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "--", "*.md"], cwd=ROOT, check=True,
                                stdout=subprocess.PIPE, text=True).stdout.split()
        files = [os.path.join(ROOT, name) for name in listed if os.path.exists(os.path.join(ROOT, name))]
    broken = [line for path in files for line in broken_links(os.path.abspath(path))]
    print("\n".join(broken) if broken else f"{len(files)} files, all links lead somewhere")
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
