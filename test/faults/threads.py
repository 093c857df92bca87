"""slam_node with ThreadSanitizer, asked for everything at once."""
import os
import re
import tempfile
import threading

import rospy
from dynamic_reconfigure.client import Client

from kinect_ekf_slam.srv import LoadMap, SaveMap, SetMode
from damaged_messages import START
from programs import ROOT, build_folder
from row import Row
from slam_run import SlamRun
from std_srvs.srv import SetBool, Trigger

SUPPRESSIONS = os.path.join(ROOT, "test", "faults", "thread_sanitizer.txt")
ASKED = (("save_map", SaveMap, ("a.yaml",)), ("load_map", LoadMap, ("a.yaml", False)), ("pause", SetBool, (True,)), ("pause", SetBool, (False,)),
         ("set_mode", SetMode, ("localization",)), ("set_mode", SetMode, ("slam",)), ("relocalize", Trigger, ()), ("reset", Trigger, ()))


def _ask(run, stop, counts):
    client = Client(run.process.name + "/live", timeout=60)
    while not stop.is_set():
        for name, kind, arguments in ASKED:
            run.call(name, kind, *arguments)
            counts["services"] += 1
        client.update_configuration({"sensor_max_depth": 2.0 + 0.1 * (counts["changes"] % 5)})
        counts["changes"] += 1
    client.close()


def _drive(run, seconds):
    stop, counts = threading.Event(), {"services": 0, "changes": 0}
    asker = threading.Thread(target=_ask, args=(run, stop, counts))
    asker.start()
    try:
        run.drive(seconds, expect_use=False)
    finally:
        stop.set()
        asker.join()
    return counts


def threads(quick):
    build = build_folder("thread", quick)
    must_hold = "no data race, no deadlock (`test/faults/thread_sanitizer.txt` names what is roscpp's, with reasons)"
    if build is None:
        return Row("`slam_node` with ThreadSanitizer", "none", must_hold, "not run: scripts/build_sanitized.sh thread", True)
    seconds = 10 if quick else 120
    with tempfile.TemporaryDirectory(prefix="faults_threads_") as folder:
        os.environ["TSAN_OPTIONS"] = f"suppressions={SUPPRESSIONS} log_path={folder}/report exitcode=0"
        try:
            with SlamRun({"map/autosave_period": 0.1}, build=build, with_imu=True, speed=0.02, start=START) as run:
                counts = _drive(run, seconds)
        finally:
            del os.environ["TSAN_OPTIONS"]
        reports = ""
        for name in os.listdir(folder):
            with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
                reports += file.read()
    found = re.findall(r"^SUMMARY: ThreadSanitizer: (.*)$", reports, re.MULTILINE)
    if found:
        rospy.logerr("%s", reports)
    return Row("`slam_node` with ThreadSanitizer, driven while services and dynamic_reconfigure are called",
               f"{seconds} s of data, {counts['services']} services, {counts['changes']} changes", must_hold,
               f"{len(found)} reports" + (f", the first: {found[0]}" if found else ""), not found)
