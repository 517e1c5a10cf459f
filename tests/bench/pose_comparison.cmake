# pose_comparison beside its peers: the Point Cloud Library and OpenCV's contributed modules.
if(NOT VANTAGE_BUILD_BENCHMARKS)
  return()
endif()
find_package(PCL 1.13 REQUIRED COMPONENTS search filters features registration)
find_package(OpenCvSurfaceMatching REQUIRED)
file(GLOB pose_comparison_sources CONFIGURE_DEPENDS pose_comparison/*.cc)
vantage_benchmark(pose_comparison
  SOURCES object_views.cc ${pose_comparison_sources}
    ${CMAKE_SOURCE_DIR}/tools/evaluate/pose_success.cc ${CMAKE_SOURCE_DIR}/nodes/command_line.cc
  LINK vantage_perception vantage_fusion vantage_drivers_sim
    pcl_search pcl_filters pcl_features pcl_registration
    OpenCvSurfaceMatching::OpenCvSurfaceMatching)
target_include_directories(pose_comparison SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
target_compile_definitions(pose_comparison PRIVATE ${PCL_DEFINITIONS})
# GCC 12 sees reads past the end in what it inlines of Eigen into these libraries' templates.
set_source_files_properties(pose_comparison/opencv_ppf.cc pose_comparison/pcl_clouds.cc
  pose_comparison/pcl_ppf.cc pose_comparison/pcl_shot.cc PROPERTIES COMPILE_OPTIONS -Wno-array-bounds)
