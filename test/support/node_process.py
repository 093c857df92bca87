"""One of the package's nodes as a process, and what it publishes."""
import os
import signal
import subprocess
import sys
import tempfile

import roslib.packages
import rospy

from waiting import DEADLINE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

sys.path.insert(0, os.path.join(ROOT, "scripts"))

from slam_tools.live import hears  # noqa: E402


def executable(name):
    """The path of one of the package's programs."""
    found = roslib.packages.find_node("kinect_ekf_slam", name)
    if not found:
        raise FileNotFoundError(f"{name}: not in the build, or being built just now; scripts/build.sh builds it")
    return found[0]


class NodeProcess:
    """A node in a namespace, with `parameters` in its private one; of another build folder than the tests' if one is given."""

    def __init__(self, program, namespace, parameters, remappings=(), build=None):
        self.name = namespace + "/" + program
        rospy.set_param(self.name, parameters)
        self._stderr = tempfile.TemporaryFile(mode="w+")
        command = [os.path.join(build, "devel", "env.sh"), program] if build else [executable(program)]
        self._process = subprocess.Popen(
            [*command, "__ns:=" + namespace, "__name:=" + program, *remappings],
            stdout=subprocess.DEVNULL, stderr=self._stderr)

    def said(self):
        """What it has written to stderr."""
        self._stderr.seek(0)
        return self._stderr.read()

    def is_running(self):
        return self._process.poll() is None

    def exit_code(self):
        """Waits for the end."""
        return self._process.wait(timeout=DEADLINE)

    def kill(self):
        """As a power cut does: the node learns nothing of it."""
        self._process.kill()
        self._process.wait()

    def memory(self):
        """Bytes that it holds now."""
        with open("/proc/%d/statm" % self._process.pid, encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")

    def stop(self):
        if self.is_running():
            self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(timeout=DEADLINE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            raise


class Recorder:
    """All messages of one topic."""

    def __init__(self, topic, kind):
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=None, tcp_nodelay=True)

    @property
    def last(self):
        return self.messages[-1] if self.messages else None

    def is_connected(self):
        return hears(self._subscriber)

    def close(self):
        self._subscriber.unregister()
