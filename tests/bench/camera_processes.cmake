vantage_benchmark(camera_process_bench
  SOURCES camera_process_bench.cc
  LINK vantage_nodes)
