#!/usr/bin/python3
"""README.md names what the running node has, and the node has what README.md names."""
import os
import re
import unittest

import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
NODE = "/slam_node"
# What every node has, and what tf and dynamic_reconfigure bring along.
INFRASTRUCTURE = ("/rosout", "/tf", "/tf_static", "/clock", NODE + "/live/", NODE + "/get_loggers", NODE + "/set_logger_level")


def table(title):
    """The rows of the first table below a heading of README.md, each a list of cells."""
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        section = file.read().split(f"### {title}\n", 1)[1].split("\n### ", 1)[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in section.splitlines() if line.startswith("| `")]
    return [[re.sub("`", "", cell) for cell in row] for row in rows]


def resolved(name):
    return NODE + "/" + name[1:] if name.startswith("~") else "/" + name.lstrip("/")


def system_state():
    """Topics that the node publishes, those it subscribes to, its services."""
    publishers, subscribers, services = rosgraph.Master("/test_readme").getSystemState()
    return [{name for name, nodes in part if NODE in nodes and not name.startswith(INFRASTRUCTURE)}
            for part in (publishers, subscribers, services)]


class ReadmeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_readme", anonymous=True)
        rospy.wait_for_message("/diagnostics", DiagnosticArray, 20.0)  # it spins: everything is connected
        cls.published, cls.subscribed, cls.services = system_state()
        cls.types = dict(rosgraph.Master("/test_readme").getTopicTypes())

    def test_topics_are_those_of_the_node(self):
        rows = table("Topics")
        inputs = {resolved(row[0]) for row in rows if row[2].startswith("in")}
        outputs = {resolved(row[0]) for row in rows if row[2].startswith("out")}
        self.assertEqual(inputs, self.subscribed)
        self.assertEqual(outputs, self.published)

    def test_types_are_those_of_the_node(self):
        for row in table("Topics"):
            known = self.types.get(resolved(row[0]))
            if known not in (None, "*"):
                self.assertEqual(row[1], known, row[0])

    def test_services_are_those_of_the_node(self):
        self.assertEqual({resolved(row[0]) for row in table("Services")}, self.services)

    def test_frames_are_the_parameters_of_the_node(self):
        for frame, parameter, *_ in table("Frames"):
            self.assertEqual(rospy.get_param(NODE + "/" + parameter), frame)


if __name__ == "__main__":
    rostest.rosrun("kinect_ekf_slam", "test_readme", ReadmeTest)
