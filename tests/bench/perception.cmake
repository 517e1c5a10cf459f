vantage_benchmark(perception_bench
  SOURCES perception_bench.cc
  LINK vantage_perception vantage_drivers_sim vantage_tools_support benchmark::benchmark_main)
