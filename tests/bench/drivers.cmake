if(VANTAGE_BUILD_BENCHMARKS)
  find_package(OpenCvCalibration REQUIRED)
  find_library(OPENCV_RGBD_LIBRARY opencv_rgbd REQUIRED)
endif()
vantage_benchmark(drivers_bench
  SOURCES drivers_bench.cc registration_bench.cc
  LINK vantage_bus vantage_drivers_openni2 OpenCv::calibration ${OPENCV_RGBD_LIBRARY}
       benchmark::benchmark_main)
