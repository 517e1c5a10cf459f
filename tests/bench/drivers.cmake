vantage_benchmark(drivers_bench
  SOURCES drivers_bench.cc
  LINK vantage_bus vantage_drivers_openni2 benchmark::benchmark_main)
