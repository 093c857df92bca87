#!/usr/bin/python3
"""Records what slam_node publishes as the files that slam_replay writes, for evaluate.py.

Ends with Ctrl-C, or with --until-end-of when that node (the player of a bag, say) has ended. Time going back
starts the recording anew, as it starts a new run in slam_node.
"""
import os
import socket
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

from slam_tools import cli
from slam_tools.environment import package_messages

DEFINITIONS = """\
files in DIR
  trajectory.tum              ~pose, one line for each odometry message
  trajectory_covariance.csv   its covariance
  dead_reckoning.tum          the odometry's own pose: the wheels alone. (slam_replay writes what the pipeline
                              makes of wheels and gyro, without landmarks.)
  landmarks.csv               the last ~map
  associations.csv            ~associations
  parameters.yaml             what the parameter server holds of the node, with what was changed while it ran
  summary.json                seconds, counts of poses, detections by verdict, landmarks; what the node's
                              diagnostics warned of
  positions.csv and beacons.csv of slam_replay are missing: slam_node publishes neither. Its diagnostics count
  what became of positions and ranges; for the files record a bag (record.launch) and replay that.
"""

POLL_PERIOD = 0.5      # s of wall time
LAST_MESSAGES = 1.0    # s of wall time, for what is still on its way


def main():
    parser = cli.ArgumentParser(description=__doc__, epilog=DEFINITIONS)
    parser.add_argument("folder", metavar="DIR", help="folder to write to")
    parser.add_argument("--node", metavar="NAME", default="/slam_node", help="default: %(default)s")
    parser.add_argument("--odom", metavar="TOPIC", default="/odom", help="default: %(default)s")
    parser.add_argument("--until-end-of", metavar="NODE", help="stop when this node has started and ended")
    parser.add_argument("--progress", metavar="S", type=float, default=0.0,
                        help="a line each S seconds that says how far it is; default: none")
    arguments = parser.parse_args()
    os.makedirs(arguments.folder, exist_ok=True)

    import rospy
    package_messages()
    from slam_tools.live import LiveRun
    rospy.init_node("record_run", anonymous=True)
    run = LiveRun(arguments.node, arguments.odom)
    wait_for_the_end(run, arguments.until_end_of, arguments.progress)
    run.write(arguments.folder)


def wait_for_the_end(run, last_node, progress_period):
    import rospy
    started = False
    waited = 0.0
    while not rospy.is_shutdown():
        rospy.rostime.wallsleep(POLL_PERIOD)
        waited += POLL_PERIOD
        if progress_period > 0.0 and waited >= progress_period:
            waited = 0.0
            print(run.progress(), flush=True)
        if last_node is None:
            continue
        running = is_running(last_node)
        if started and not running:
            rospy.rostime.wallsleep(LAST_MESSAGES)
            return
        started = started or running


def is_running(node):
    import rosgraph
    try:
        rosgraph.Master("/record_run").lookupNode(node)
        return True
    except (rosgraph.MasterError, socket.error):
        return False


if __name__ == "__main__":
    cli.run(main)
