# Finds the parts of OpenCV that know calibration targets. OpenCV's own configuration comes only with
# libopencv-dev, which brings Java with it. Defines OpenCv::calibration, and OpenCv::images, which reads
# image files.
find_path(OPENCV_INCLUDE_DIR opencv2/calib3d.hpp PATH_SUFFIXES opencv4)
set(opencv_libraries)
foreach(part aruco calib3d imgproc core imgcodecs)
  find_library(OPENCV_${part}_LIBRARY opencv_${part})
  list(APPEND opencv_libraries OPENCV_${part}_LIBRARY)
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCvCalibration
  REQUIRED_VARS OPENCV_INCLUDE_DIR ${opencv_libraries})
if(OpenCvCalibration_FOUND AND NOT TARGET OpenCv::calibration)
  add_library(OpenCv::calibration INTERFACE IMPORTED)
  target_include_directories(OpenCv::calibration SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
  target_link_libraries(OpenCv::calibration INTERFACE
    ${OPENCV_aruco_LIBRARY} ${OPENCV_calib3d_LIBRARY} ${OPENCV_imgproc_LIBRARY} ${OPENCV_core_LIBRARY})
  add_library(OpenCv::images INTERFACE IMPORTED)
  target_link_libraries(OpenCv::images INTERFACE ${OPENCV_imgcodecs_LIBRARY} OpenCv::calibration)
endif()
