# Finds the parts of PCL that compute features. PCL's own configuration is not used: it would look
# for VTK and link every program to it. Defines Pcl::features.
find_path(PCL_FEATURES_INCLUDE_DIR pcl/features/shot.h
  PATH_SUFFIXES pcl-1.15 pcl-1.14 pcl-1.13 pcl-1.12)
set(pcl_features_libraries)
foreach(part features search kdtree common)
  find_library(PCL_${part}_LIBRARY pcl_${part})
  list(APPEND pcl_features_libraries PCL_${part}_LIBRARY)
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(PclFeatures
  REQUIRED_VARS PCL_FEATURES_INCLUDE_DIR ${pcl_features_libraries})
if(PclFeatures_FOUND AND NOT TARGET Pcl::features)
  add_library(Pcl::features INTERFACE IMPORTED)
  target_include_directories(Pcl::features SYSTEM INTERFACE ${PCL_FEATURES_INCLUDE_DIR})
  target_link_libraries(Pcl::features INTERFACE
    ${PCL_features_LIBRARY} ${PCL_search_LIBRARY} ${PCL_kdtree_LIBRARY} ${PCL_common_LIBRARY}
    Eigen3::Eigen)
endif()
