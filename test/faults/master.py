"""A ROS master of one's own on a free port."""
import contextlib
import os
import socket
import subprocess
import tempfile

import rosgraph
import rospy

from waiting import wait_until


def _free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def own_master():
    """While it lasts, this process is a node of that master."""
    port = _free_port()
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_HOSTNAME="127.0.0.1")
    for name in ("ROS_IP", "ROS_NAMESPACE"):
        os.environ.pop(name, None)
    with tempfile.TemporaryDirectory(prefix="faults_log_") as log:
        os.environ["ROS_LOG_DIR"] = log
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            wait_until(rosgraph.is_master_online, "the master answers")
            rospy.init_node("faults", disable_signals=True)
            yield
            rospy.signal_shutdown("done")
        finally:
            master.terminate()
            master.wait()
