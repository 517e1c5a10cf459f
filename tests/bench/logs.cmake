vantage_benchmark(log_file_bench
  SOURCES log_file_bench.cc large_log.cc
  LINK vantage_nodes)
