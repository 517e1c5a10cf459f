vantage_benchmark(perception_bench
  SOURCES perception_bench.cc table_frames.cc
  LINK vantage_perception vantage_drivers_sim vantage_tools_support benchmark::benchmark_main)
find_package(embree 3 QUIET)
if(embree_FOUND)
  vantage_benchmark(verification_bench
    SOURCES verification_bench.cc
    LINK vantage_perception embree benchmark::benchmark_main)
else()
  message(STATUS "No Embree 3: verification_bench, of which it is the peer, is left out")
endif()
if(VANTAGE_BUILD_BENCHMARKS)
  find_package(PCL 1.13 REQUIRED COMPONENTS filters features segmentation)
  vantage_benchmark(segmentation_bench
    SOURCES segmentation_bench.cc table_frames.cc
    LINK vantage_perception vantage_drivers_sim
      pcl_filters pcl_features pcl_segmentation benchmark::benchmark_main)
  target_include_directories(segmentation_bench SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
  target_compile_definitions(segmentation_bench PRIVATE ${PCL_DEFINITIONS})
  # GCC 12 sees reads past the end in what it inlines of Eigen into these libraries' templates.
  set_source_files_properties(segmentation_bench.cc PROPERTIES COMPILE_OPTIONS -Wno-array-bounds)
endif()
