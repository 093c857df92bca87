# find_package(kinect_ekf_slam_core) for plain CMake: link kinect_ekf_slam::estimators. With catkin: find_package(kinect_ekf_slam).
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 NO_MODULE)
include(${CMAKE_CURRENT_LIST_DIR}/kinect_ekf_slam_coreTargets.cmake)
