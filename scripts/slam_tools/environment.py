"""Finds a Python that has the ROS packages, and the package's own messages."""
import importlib.util
import os
import sys
from xml.etree import ElementTree

SYSTEM_PYTHON = "/usr/bin/python3"
_MARK = "KINECT_EKF_SLAM_SYSTEM_PYTHON"


def use_system_python():
    """Starts the running script again with the system's Python when this one lacks a package.

    ROS is installed for the system's Python; a `python3` that comes earlier in PATH does not see it.
    """
    missing = [name for name in ("rosbag", "numpy", "matplotlib") if importlib.util.find_spec(name) is None]
    if not missing:
        return
    if os.environ.get(_MARK) or not os.path.exists(SYSTEM_PYTHON):
        print(f"{os.path.basename(sys.argv[0])}: error: Python package {missing[0]} is not installed; "
              "scripts/install_dependencies.sh installs it", file=sys.stderr)
        sys.exit(2)
    os.execve(SYSTEM_PYTHON, [SYSTEM_PYTHON] + sys.argv, dict(os.environ, **{_MARK: "1"}))


def executable(name):
    """Path of one of the package's programs: installed beside the scripts, or of the build next to them."""
    scripts = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    for folder in (scripts, os.path.join(os.path.dirname(scripts), "build", "devel", "lib", "kinect_ekf_slam")):
        path = os.path.join(folder, name)
        if os.access(path, os.X_OK):
            return path
    from .cli import InputError
    raise InputError(f"{name} is not built: run scripts/build.sh")


def package_file(*parts):
    """Path of one of the package's files, in the checkout or where it is installed."""
    above = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
    installed = os.path.join(os.path.dirname(above), "share", "kinect_ekf_slam")
    return os.path.join(above if os.path.exists(os.path.join(above, "package.xml")) else installed, *parts)


def package_version():
    return ElementTree.parse(package_file("package.xml")).findtext("version")


def package_messages():
    """The generated module `kinect_ekf_slam.msg`: of the environment, or of the build next to the scripts."""
    try:
        import kinect_ekf_slam.msg
        return kinect_ekf_slam.msg
    except ImportError:
        pass
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
    sys.path.append(os.path.join(root, "build", "devel", "lib", "python3", "dist-packages"))
    try:
        import kinect_ekf_slam.msg
        return kinect_ekf_slam.msg
    except ImportError:
        from .cli import InputError
        script = os.path.basename(sys.argv[0])
        raise InputError("the package's messages are not built: run scripts/build.sh, "
                         f"then build/devel/env.sh python3 scripts/{script} ...") from None
