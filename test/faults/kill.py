"""slam_node is killed while it saves its map."""
import os
import random
import tempfile
import threading
import time

import rospy
import yaml

from kinect_ekf_slam.srv import SaveMap
from row import Row, number
from slam_run import SlamRun, read_yaml
from waiting import wait_until

FILE = "kept.yaml"
# So many that writing them takes a while: most kills come while the file is written.
LANDMARKS = {8 * i + j: ("", 0.9 + 0.2 * i, 0.2 * (j - 3.5)) for i in range(8) for j in range(8)}
OVERRIDES = {"map/autosave_period": 0.01, "map/file_name": FILE, "association/type": "known"}
LONGEST = 0.3  # s from when the node saves to its end


def _save_until_killed(run):
    try:
        while True:
            run.call("save_map", SaveMap, FILE)
    except (rospy.ServiceException, rospy.ROSException, OSError):
        pass


def _kill_while_saving(run, path, delay):
    wait_until(lambda: (run.drive(0.2, expect_use=False), os.path.exists(path))[1], "a map is saved")
    saver = threading.Thread(target=_save_until_killed, args=(run,))
    saver.start()
    end = time.monotonic() + delay
    while time.monotonic() < end:
        run.drive(0.2, expect_use=False)
    run.process.kill()
    saver.join()


def _read_if_whole(path):
    try:
        saved = read_yaml(path)
        rows = saved["covariance_lower_triangle"]
        if (len(saved["landmarks"]) == len(LANDMARKS) and [len(row) for row in rows] == list(range(1, 4 + 2 * len(LANDMARKS))) and
                "autosave_period" in saved["parameters"]):
            return saved
    except (yaml.YAMLError, KeyError, TypeError):
        pass
    return None


def kill(quick):
    count = 3 if quick else 100
    choice = random.Random(1)
    whole, resumed, saved = 0, 0, None
    with tempfile.TemporaryDirectory(prefix="faults_kill_") as folder:
        path = os.path.join(folder, FILE)
        for again in range(count + 1):
            with SlamRun({**OVERRIDES, "map/load_at_start": again > 0}, map_directory=folder, landmarks=LANDMARKS,
                         speed=0.0, turn=0.0) as run:
                resumed += again > 0 and run.saved_map()["landmarks"] == saved["landmarks"]
                if again == count:
                    break
                _kill_while_saving(run, path, choice.uniform(0.0, LONGEST))
            saved = _read_if_whole(path)
            if saved is None:
                break
            whole += 1
        left = len([name for name in os.listdir(folder) if name.startswith(FILE + ".")])
    return Row("`slam_node` killed (SIGKILL) at a random moment, while it autosaves and while `~save_map` is called", number(count),
               "the map file is whole; the node started next has the same landmarks; no part of a file lies about",
               f"{number(whole)} files whole, {number(resumed)} resumed, {left} parts of files", whole == resumed == count and left == 0)
