vantage_benchmark(perception_bench
  SOURCES perception_bench.cc
  LINK vantage_perception vantage_drivers_sim vantage_tools_support benchmark::benchmark_main)
find_package(embree 3 QUIET)
if(embree_FOUND)
  vantage_benchmark(verification_bench
    SOURCES verification_bench.cc
    LINK vantage_perception embree benchmark::benchmark_main)
else()
  message(STATUS "No Embree 3: verification_bench, of which it is the peer, is left out")
endif()
