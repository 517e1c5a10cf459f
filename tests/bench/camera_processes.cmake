vantage_benchmark(camera_process_bench
  SOURCES camera_process_bench.cc
  LINK vantage_nodes)
vantage_benchmark(write_table_frames
  SOURCES write_table_frames.cc table_frames.cc
  LINK vantage_drivers_sim vantage_perception)
