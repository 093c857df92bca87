#!/usr/bin/python3
"""What Doxygen reads in place of a Markdown file: GitHub's formulas, anchors and links in Doxygen's own terms.

  docs/doxygen_filter.py FILE.md     (docs/Doxyfile calls it)
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "scripts"))
from slam_tools.markdown import HEADING, LINK, anchors, outside_blocks, outside_code  # noqa: E402

PAGES = ("README.md", "docs")    # what has a page; other files are named without a link


def label(path, anchor=""):
    """Doxygen's name of a page or of a heading in it."""
    return re.sub(r"\W", "_", os.path.relpath(path, ROOT) + ("_" + anchor if anchor else ""))


def link(match, path):
    mark, text, target = match.groups()
    if re.match(r"[a-z]+:", target):
        return match.group()
    name, _, anchor = target.partition("#")
    linked = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
    if mark:
        return f"![{text}]({os.path.basename(linked)})"
    if not linked.endswith(".md") or os.path.relpath(linked, ROOT).split(os.sep)[0] not in PAGES:
        return text
    return f"[{text}](@ref {label(linked, anchor)})"


def formulas(text):
    text = re.sub(r"\$\$(.+?)\$\$", r"\\f[\1\\f]", text, flags=re.DOTALL)
    return re.sub(r"(?<!\\f)\$(?!\s)([^$\n]+?)\$", r"\\f$\1\\f$", text)


def headings(text, path):
    """Each gets its label; that of the page is the first one's."""
    labels = [label(path)] + [label(path, anchor) for anchor in anchors(text)[1:]]
    return outside_blocks(text, lambda part: HEADING.sub(
        lambda heading: f"{heading.group(1)} {heading.group(2)} {{#{labels.pop(0)}}}", part))


def main():
    path = os.path.abspath(sys.argv[1])
    with open(path, encoding="utf-8") as file:
        text = headings(file.read(), path)
    text = outside_blocks(text, lambda part: LINK.sub(lambda match: link(match, path), part))
    sys.stdout.write(outside_code(text, formulas))


if __name__ == "__main__":
    main()
