#!/usr/bin/python3
"""Runs the cylinder detector on labelled Kinect frames and compares what it finds with the truth.

FOLDER holds for each frame NAME_rgb.png, NAME_depth.png (16 bit, mm) and NAME_label.png (16 bit: object number,
tens; 0 none), and truth.csv (frame,label,class,x,y,z,radius,height): class `upright` is a standing cylinder with
its axis point at half its height in the optical frame (m), `no` is none, `optional` may be found or not.
"""
import csv
import json
import math
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import numpy as np
from PIL import Image

from slam_tools import cli
from slam_tools.environment import executable, package_file

MATCH_DISTANCE = 0.05   # m, between a finding and the true axis point
EPILOG = """\
keys of the JSON file
  found, expected, recall      upright cylinders that were found, that there are, and the share
  false_positives              findings that are no upright and no optional object
  center_rmse_m, radius_rmse_m of those that were found; null: none was
  ms_per_frame                 on one core, without reading the pictures; mean over the frames
"""


def finite(text):
    if not math.isfinite(float(text)):
        raise ValueError(text)
    return float(text)


def read_truth(folder):
    """{frame: [row of truth.csv, with numbers where there are some]}."""
    path = os.path.join(folder, "truth.csv")
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise cli.InputError(f"{path}: not a table as text: {error}") from None
    if not rows:
        raise cli.InputError(f"{path}: holds no frames")
    frames = {}
    for row in rows:
        try:
            entry = {"class": row["class"], "label": int(row["label"])}
            if entry["class"] == "upright":
                entry["center"] = [finite(row[axis]) for axis in "xyz"]
                entry["radius"] = finite(row["radius"])
            if not re.fullmatch(r"[\w.-]+", row["frame"]):
                raise ValueError(row["frame"])
            frames.setdefault(row["frame"], []).append(entry)
        except (KeyError, TypeError, ValueError):
            raise cli.InputError(f"{path}: {row}: needed: frame,label,class,x,y,z,radius,height") from None
    return frames


def detect(folder, frames, camera):
    """{frame: the detector's line on it}."""
    files = [os.path.join(folder, f"{frame}_{kind}.png") for frame in frames for kind in ("rgb", "depth")]
    command = [executable("detect_picture"), "--palette", package_file("config", "palette.yaml"), "--camera"]
    process = subprocess.run(command + [str(number) for number in camera] + files, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, universal_newlines=True, check=False)
    if process.returncode != 0:
        raise cli.InputError(process.stderr.strip())
    return dict(zip(frames, map(json.loads, process.stdout.splitlines())))


class Labels:
    """The objects of a frame, by the pixels that they cover."""

    def __init__(self, folder, frame, camera):
        self.fx, self.fy, self.cx, self.cy = camera
        path = os.path.join(folder, f"{frame}_label.png")
        self.image = None
        if os.path.exists(path):
            try:
                self.image = np.array(Image.open(path)).astype(int)
            except (OSError, SyntaxError) as error:
                raise cli.InputError(f"{path}: not a readable picture: {error}") from None
            if self.image.ndim != 2:
                raise cli.InputError(f"{path}: in colour, needed: numbers of objects as grey levels")

    def object_at(self, position):
        """Number of the object that a point of the optical frame is seen on, tens; 0: none."""
        if self.image is None:
            return 0
        column = round(self.fx * position[0] / position[2] + self.cx)
        row = round(self.fy * position[1] / position[2] + self.cy)
        inside = 0 <= row < self.image.shape[0] and 0 <= column < self.image.shape[1]
        return int(self.image[row, column]) // 10 * 10 if inside else 0


def compare(findings, truth, labels):
    """([(error of centre, of radius)] of the upright objects found, number of false positives) of a frame."""
    pairs = sorted((math.dist(finding["position"], entry["center"]), i, j)
                   for i, finding in enumerate(findings) for j, entry in enumerate(truth)
                   if entry["class"] == "upright")
    errors, used, matched = [], set(), set()
    for distance, i, j in pairs:
        if distance < MATCH_DISTANCE and i not in used and j not in matched:
            used.add(i)
            matched.add(j)
            errors.append((distance, findings[i]["radius"] - truth[j]["radius"]))
    optional = {entry["label"] // 10 * 10 for entry in truth if entry["class"] == "optional"}
    false = sum(i not in used and labels.object_at(finding["position"]) not in optional
                for i, finding in enumerate(findings))
    return errors, false


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values)) if values else None


def evaluate(folder, camera):
    frames = read_truth(folder)
    lines = detect(folder, frames, camera)
    errors, false_positives = [], 0
    for frame, truth in frames.items():
        found, false = compare(lines[frame]["found"], truth, Labels(folder, frame, camera))
        errors += found
        false_positives += false
        uprights = sum(entry["class"] == "upright" for entry in truth)
        print(f"{frame}: {len(found)} of {uprights} upright, {false} false, "
              f"{len(lines[frame]['found'])} reported, {len(lines[frame]['refused'])} refused, "
              f"{lines[frame]['ms']:.1f} ms")
    expected = sum(entry["class"] == "upright" for truth in frames.values() for entry in truth)
    return {"recall": len(errors) / expected if expected else None, "found": len(errors), "expected": expected,
            "false_positives": false_positives, "center_rmse_m": rms([center for center, _ in errors]),
            "radius_rmse_m": rms([radius for _, radius in errors]),
            "ms_per_frame": sum(line["ms"] for line in lines.values()) / len(lines)}


def main():
    parser = cli.ArgumentParser(description=__doc__, epilog=EPILOG)
    parser.add_argument("folder", metavar="FOLDER", help="labelled frames and truth.csv")
    parser.add_argument("--json", metavar="FILE", help="write the figures there")
    parser.add_argument("--camera", nargs=4, type=float, metavar=("FX", "FY", "CX", "CY"),
                        default=(525.0, 525.0, 319.5, 239.5), help="pixels (default: %(default)s)")
    arguments = parser.parse_args()
    figures = evaluate(arguments.folder, arguments.camera)
    print()
    for key, value in figures.items():
        print(f"{key:16s} {value:.4g}" if isinstance(value, float) else f"{key:16s} {value}")
    if arguments.json:
        with cli.atomic_output(arguments.json) as path, open(path, "w", encoding="utf-8") as file:
            json.dump(figures, file, indent=2)
            file.write("\n")


if __name__ == "__main__":
    cli.run(main)
