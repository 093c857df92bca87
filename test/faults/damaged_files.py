"""Damaged map, parameter and bag files."""
import os
import random
import re
import tempfile

from programs import ROOT, build_folder, fuzz, run
from row import Row, number
from slam_tools import cli

SNAGS = (b"\x00", b"\xff\xff\xff\xff", b"\x00\x00\x00\x80", b"\xff", b"op=", b"\x0a")


def parsers(quick):
    return fuzz("damaged map files and parameter files", "{} of each",
                "refused with one line that names the file, or what is read is finite and inside its bounds",
                "fuzz_slam", "FuzzSlam.DamagedMaps*:FuzzSlam.DamagedParameters*", 300 if quick else 10000, build_folder("address", quick))


def bag_messages(quick):
    """Without sanitizers: a length may be damaged so that no memory holds it, which AddressSanitizer lets no program survive."""
    return fuzz("bags in which a message is damaged, replayed", "{}", "refused with one line that names the file, or replayed",
                "fuzz_slam", "FuzzSlam.DamagedMessagesInBags*", 300 if quick else 10000, None)


def _damaged(sound, choice):
    """Bytes of the whole file changed, lost or doubled: most often in what says where things are."""
    text = bytearray(sound)
    for _ in range(choice.randint(1, 3)):
        at = choice.randrange(len(text))
        kind = choice.randrange(5)
        if kind == 0:
            text[at] = choice.randrange(256)
        elif kind == 1:
            del text[at:at + choice.randint(1, 40)]
        elif kind == 2:
            text[at:at] = text[at:at + choice.randint(1, 40)]
        elif kind == 3:
            snag = choice.choice(SNAGS)
            text[at:at + len(snag)] = snag
        elif choice.random() < 0.2:
            del text[at + 1:]
    return bytes(text)


def _short_bag(path):
    """A second of a simulated run."""
    import rosbag
    with rosbag.Bag(os.path.join(ROOT, "bags", "room.bag")) as long, rosbag.Bag(path, "w") as short:
        begin = None
        for topic, message, stamp in long.read_messages(raw=True):
            begin = begin or stamp
            if (stamp - begin).to_sec() > 1.0:
                break
            short.write(topic, message, stamp, raw=True)


def _is_rosbags(report):
    """Whether the innermost frame of AddressSanitizer's report that is not the C library's is in rosbag's library or its headers."""
    frames = re.findall(r"^ +#\d+ 0x\w+ in (.*)$", report, re.MULTILINE)
    own = [frame for frame in frames if not re.search(r"/lib(c|asan|m|stdc\+\+)\.so|libsanitizer|/sysdeps/", frame)]
    return bool(own) and ("librosbag_storage" in own[0] or "rosbag::Bag::" in own[0])


def bags(quick):
    """slam_replay is a process a bag: what crashes in rosbag's own library is counted, and is not ours."""
    count = 100 if quick else 3000
    choice = random.Random(3)
    build = build_folder("address", quick)
    ends, crashes, faults = {0: 0, 2: 0}, 0, []
    with tempfile.TemporaryDirectory(prefix="faults_bags_") as folder:
        path = os.path.join(folder, "run.bag")
        _short_bag(path)
        with open(path, "rb") as file:
            sound = file.read()
        for _ in cli.progress(range(count), count, "Damaging"):
            with open(path, "wb") as file:
                file.write(_damaged(sound, choice))
            code, text = run("slam_replay", path)
            if code == 0 or code == 2 and "".join(text.splitlines()[-1:]).startswith(f"slam_replay: {path}: "):
                ends[code] += 1
            elif code < 0 and (build is None or _is_rosbags(run("slam_replay", path, build=build, ASAN_OPTIONS="detect_leaks=0")[1])):
                crashes += 1
            else:
                faults.append(f"exit code {code}: {' '.join(text.split())[:200]}")
    where = "inside rosbag's own library" if build else "by a signal; whose fault that is only a build with AddressSanitizer tells"
    result = f"{number(ends[0])} replayed, {number(ends[2])} refused, {number(crashes)} ended {where}"
    if faults:
        result += f"; {len(faults)} other ends, the first: {faults[0]}"
    return Row("bag files damaged anywhere, read by `slam_replay`", number(count),
               "replayed, or refused with one line; rosbag's own library crashes on some indices, which is counted apart", result, not faults)
