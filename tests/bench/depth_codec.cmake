if(VANTAGE_BUILD_BENCHMARKS)
  find_library(ZSTD_LIBRARY zstd REQUIRED)
  find_library(LZ4_LIBRARY lz4 REQUIRED)
endif()
vantage_benchmark(depth_codec_bench
  SOURCES depth_codec_bench.cc depth_codecs.cc rvl.cc table_frames.cc
  LINK vantage_depth_codec vantage_drivers_sim vantage_perception vantage_tools_support PNG::PNG ZLIB::ZLIB
       ${ZSTD_LIBRARY} ${LZ4_LIBRARY})
