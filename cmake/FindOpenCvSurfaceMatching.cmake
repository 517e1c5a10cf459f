# Finds OpenCV's surface_matching of libopencv-contrib-dev, which alone brings no CMake
# configuration. Defines OpenCvSurfaceMatching::OpenCvSurfaceMatching.
find_path(OPENCV_SURFACE_MATCHING_INCLUDE_DIR opencv2/surface_matching.hpp PATH_SUFFIXES opencv4)
find_library(OPENCV_SURFACE_MATCHING_LIBRARY opencv_surface_matching)
find_library(OPENCV_CORE_LIBRARY opencv_core)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCvSurfaceMatching REQUIRED_VARS
  OPENCV_SURFACE_MATCHING_LIBRARY OPENCV_CORE_LIBRARY OPENCV_SURFACE_MATCHING_INCLUDE_DIR)
if(OpenCvSurfaceMatching_FOUND AND NOT TARGET OpenCvSurfaceMatching::OpenCvSurfaceMatching)
  add_library(OpenCvSurfaceMatching::OpenCvSurfaceMatching UNKNOWN IMPORTED)
  set_target_properties(OpenCvSurfaceMatching::OpenCvSurfaceMatching PROPERTIES
    IMPORTED_LOCATION ${OPENCV_SURFACE_MATCHING_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_SURFACE_MATCHING_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES ${OPENCV_CORE_LIBRARY})
endif()
