# Installs the core layers for plain CMake, whether ROS is there or not: find_package(kinect_ekf_slam_core).
include(CMakePackageConfigHelpers)
set(config_folder lib/cmake/${PROJECT_NAME}_core)
set(version_file ${PROJECT_BINARY_DIR}/${PROJECT_NAME}_coreConfigVersion.cmake)
write_basic_package_version_file(${version_file} COMPATIBILITY SameMinorVersion)
#catkin_lint: ignore_once missing_file unsorted_list
install(FILES cmake/${PROJECT_NAME}_coreConfig.cmake ${version_file} DESTINATION ${config_folder})
install(EXPORT ${PROJECT_NAME}_core NAMESPACE ${PROJECT_NAME}:: FILE ${PROJECT_NAME}_coreTargets.cmake
  DESTINATION ${config_folder})
foreach(layer ${CORE_LAYERS})
  install(DIRECTORY include/${PROJECT_NAME}/${layer} DESTINATION include/${PROJECT_NAME})
endforeach()
